"""Every compiled and every public name with what it was not made for: nothing crashes, hangs or is a SystemError."""
