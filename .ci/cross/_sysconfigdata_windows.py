"""What setuptools asks about the Python that it compiles for: CPython 3.11 for Windows, by mingw-w64 on Linux.

_PYTHON_SYSCONFIGDATA_NAME names this module; CROSS is the folder of the headers, PYTHON_DLL what is linked with.
"""

import os

_gcc = "x86_64-w64-mingw32-gcc"
build_time_vars = {
    "AR": "x86_64-w64-mingw32-ar",
    "ARFLAGS": "rcs",
    "CC": f"{_gcc} -I{os.environ['CROSS']}",
    "CCSHARED": "",
    "CFLAGS": "-DNDEBUG",
    "CXX": "x86_64-w64-mingw32-g++",
    "EXT_SUFFIX": ".cp311-win_amd64.pyd",
    "LDCXXSHARED": "",
    "LDSHARED": f"{_gcc} -shared -s -static-libgcc {os.environ['PYTHON_DLL']}",
    "MULTIARCH": "",
    "OPT": "",
    "Py_ENABLE_SHARED": 0,
    "SHLIB_SUFFIX": ".pyd",
    "SOABI": "cp311-win_amd64",
    "VERSION": "3.11",
}
