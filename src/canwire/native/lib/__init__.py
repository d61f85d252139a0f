"""Where the build puts the libraries for programs in C and C++ (setup.py, LIBRARIES)."""
