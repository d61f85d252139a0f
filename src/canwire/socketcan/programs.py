"""Which programs cannot be helped by a preloaded library, and why: told before they silently have no CAN.

Source: the ELF format (elf(5)), ld.so(8) on secure execution, what Go's linker writes.
"""

from __future__ import annotations

import os
import platform
import stat
import struct

_HEADER = struct.Struct("<4sBB10xHHIQQQIHHHHHH")
_PROGRAM = struct.Struct("<IIQQQQQQ")
_INTERPRETER = 3  # PT_INTERP
_CLASS_64, _LITTLE = 2, 1
_MACHINES = {"x86_64": 62, "aarch64": 183, "riscv64": 243}
_GO = b"\xff Go buildinf:"
_LOOKED_AT = 1 << 20
STATIC = "is linked statically: nothing can be preloaded there"
GO = "is a Go program: it makes its system calls itself"


def calls_itself(path: str) -> bool:
    """This program makes its system calls itself (it is linked statically, or Go's): supervised/ can answer them."""
    return trouble_with(path) in (STATIC, GO) and platform.machine() in ("x86_64", "aarch64")


def trouble_with(path: str) -> str:
    """One clause about the program in this file, "" if the shim works there; scripts are their interpreters'."""
    try:
        with open(path, "rb") as file:
            start = file.read(_LOOKED_AT)
            mode = os.fstat(file.fileno()).st_mode
    except OSError:
        return ""  # exec says what is wrong
    if start[:2] == b"#!":
        words = start[2:].split(b"\n", 1)[0].split()
        return trouble_with(os.fsdecode(words[0])) if words else ""
    if start[:4] != b"\x7fELF" or len(start) < _HEADER.size:
        return ""
    if mode & (stat.S_ISUID | stat.S_ISGID) and os.geteuid() != 0:
        return "is set-uid or set-gid: the loader preloads nothing there"
    return _trouble_with_elf(start)


def _trouble_with_elf(start: bytes) -> str:
    _, word, order, _, machine, _, _, at, _, _, _, size, count, *_ = _HEADER.unpack_from(start)
    ours = _MACHINES.get(platform.machine())
    if word != _CLASS_64 or order != _LITTLE or (ours is not None and machine != ours):
        return "is for another machine than canwire's shim"
    interpreter = b""
    for number in range(count):
        place = at + number * size
        if place + _PROGRAM.size > len(start):
            break
        kind, _, offset, _, _, length, _, _ = _PROGRAM.unpack_from(start, place)
        if kind == _INTERPRETER:
            interpreter = start[offset : offset + length].rstrip(b"\0")
    if not interpreter:
        return STATIC
    if b"musl" in interpreter:
        return "is linked with musl: canwire's shim is for glibc"
    if _GO in start:
        return GO
    return ""
