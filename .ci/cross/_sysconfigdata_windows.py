"""What setuptools asks about the Python that it compiles for: a CPython for 64-bit Windows, by mingw-w64 on Linux.

_PYTHON_SYSCONFIGDATA_NAME names this module; CROSS is the folder of the headers, PYTHON_DLL what is linked with:
python313.dll, which says the version; OPTIMISE is the compiler's -O.
"""

import os
import re
from pathlib import Path

_dll = os.environ["PYTHON_DLL"]
_major, _minor = re.fullmatch(r"python(\d)(\d+)\.dll", Path(_dll).name).groups()  # type: ignore[union-attr]
_gcc = "x86_64-w64-mingw32-gcc"
build_time_vars = {
    "AR": "x86_64-w64-mingw32-ar",
    "ARFLAGS": "rcs",
    "CC": f"{_gcc} -I{os.environ['CROSS']}",
    "CCSHARED": "",
    "CFLAGS": f"-DNDEBUG -g0 -fno-strict-aliasing {os.environ.get('OPTIMISE', '-O2')}",
    "CXX": "x86_64-w64-mingw32-g++",
    "EXT_SUFFIX": f".cp{_major}{_minor}-win_amd64.pyd",
    "LDCXXSHARED": "",
    "LDSHARED": f"{_gcc} -shared -s -static-libgcc {_dll}",
    "MULTIARCH": "",
    "OPT": "",
    "Py_ENABLE_SHARED": 0,
    "SHLIB_SUFFIX": ".pyd",
    "SOABI": f"cp{_major}{_minor}-win_amd64",
    "VERSION": f"{_major}.{_minor}",
    "py_version_nodot": f"{_major}{_minor}",
}
