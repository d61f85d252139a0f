"""Logs packed with gzip (by Python) or Zstandard (by pyarrow): `drive.log.gz`, `drive.blf.zst`."""

from __future__ import annotations

import io
import zlib
from contextlib import suppress
from typing import Any, BinaryIO, cast

from canwire.errors import BadLog

GZIP, ZSTD = ".gz", ".zst"
SUFFIXES = (GZIP, ZSTD)
NEEDS_PATH = ("mf4", "sqlite", "parquet", "trace", "journal")
"""Formats that cannot be packed: a library opens the file by its name, or it is read from its end."""
_MAGIC = {GZIP: b"\x1f\x8b", ZSTD: b"\x28\xb5\x2f\xfd"}
_READ = 1 << 18
_MEMBER = 16 + zlib.MAX_WBITS  # zlib's way to say gzip


def packing_of(path: str) -> str:
    """Return the packing suffix of a file's name: ".gz", ".zst" or "" (not packed)."""
    return next((suffix for suffix in SUFFIXES if path.lower().endswith(suffix)), "")


def unpacked_name(path: str) -> str:
    """Return the name without the packing suffix; its remaining suffix gives the format."""
    return path[: len(path) - len(packing_of(path))]


def unpacked(path: str, file: BinaryIO, head: bytes) -> tuple[BinaryIO, Unpacking | None]:
    """Return the unpacked content and its reader; the file itself if its first bytes show that it is not packed."""
    suffix = next((suffix for suffix, magic in _MAGIC.items() if head.startswith(magic)), "")
    if not suffix:
        return file, None
    unpacking = _Gzip(path, file) if suffix == GZIP else _Zstd(path, file)
    return cast(BinaryIO, io.BufferedReader(unpacking, _READ)), unpacking


class Unpacking(io.RawIOBase):
    """The content of a packed file; it can be rewound. `problem` says why the content is incomplete, "" if it is
    complete."""

    def __init__(self, path: str, file: BinaryIO) -> None:
        self.problem = ""
        self._path = path
        self._packed = file
        self._left = b""
        self._at = 0
        self._begin()

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return self._packed.seekable()

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Rewind to the beginning; raises UnsupportedOperation for other positions."""
        if (offset, whence) == (0, io.SEEK_CUR):
            return self._at
        if (offset, whence) != (0, io.SEEK_SET):
            raise io.UnsupportedOperation(f"{self._path}: a packed log is read from its beginning")
        self._packed.seek(0)
        self.problem, self._left, self._at = "", b"", 0
        self._begin()
        return 0

    def readinto(self, buffer: Any) -> int:
        while not self._left and not self.problem:
            piece = self._more()
            if piece is None:
                break
            self._left = piece  # perhaps the last one, with a problem behind it
        count = min(len(buffer), len(self._left))
        buffer[:count], self._left = self._left[:count], self._left[count:]
        self._at += count
        return count

    def _begin(self) -> None:
        raise NotImplementedError

    def _more(self) -> bytes | None:
        """Return the next bytes, possibly none; None at the end. A cut or damaged file sets `problem`."""
        raise NotImplementedError


class _Gzip(Unpacking):
    """Unpacks gzip members one after the other, as `cat a.gz b.gz` makes them."""

    def _begin(self) -> None:
        self._member = zlib.decompressobj(_MEMBER)
        self._rest = b""

    def _more(self) -> bytes | None:
        packed = self._rest or self._packed.read(_READ)
        self._rest = b""
        if not packed:
            if not self._member.eof:
                self.problem = "the packed file is cut, or still grows"
            return None
        if self._member.eof:
            self._member = zlib.decompressobj(_MEMBER)
        try:
            found = self._member.decompress(packed)
        except zlib.error as error:
            self.problem = f"the packed file is damaged: {error}"
            return None
        self._rest = self._member.unused_data
        return found


class _Zstd(Unpacking):
    """Unpacks Zstandard with pyarrow; raises ExtraMissing without it."""

    def _begin(self) -> None:
        from canwire.logs.tables.arrow import load_pyarrow

        arrow = load_pyarrow()
        self._given = 0
        self._stream = arrow.CompressedInputStream(arrow.PythonFile(_Borrowed(self._packed), "r"), "zstd")

    def _more(self) -> bytes | None:
        try:
            found = bytes(self._stream.read(_READ))
        except OSError as error:
            found = self._last() if self._packed.seekable() else b""
            self.problem = f"the packed file is cut, damaged, or still grows: {error}"
        self._given += len(found)
        return found or None

    def _last(self) -> bytes:
        """Return the data before the place where the file is cut: pyarrow returns nothing of a read that it cannot
        complete."""
        before = self._given
        self._packed.seek(0)
        self._begin()
        for at in range(0, before, _READ):
            self._stream.read(min(_READ, before - at))
        self._given = before
        found = bytearray()
        with suppress(OSError):
            while byte := self._stream.read(1):
                found += byte
        return bytes(found)


class _Borrowed(io.RawIOBase):
    """A file that stays open when pyarrow closes it."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        return self._file.read(size)

    def write(self, data: Any) -> int:
        return self._file.write(data)


class Packing(io.RawIOBase):
    """A file that is packed while it grows; flushed data can be read even if the rest is missing."""

    def __init__(self, path: str, file: BinaryIO) -> None:
        self._file = file
        self._ended = False
        if packing_of(path) == GZIP:
            self._gzip: Any = zlib.compressobj(6, zlib.DEFLATED, _MEMBER)
        else:
            from canwire.logs.tables.arrow import load_pyarrow

            arrow = load_pyarrow()
            self._gzip = None
            self._zstd = arrow.CompressedOutputStream(arrow.PythonFile(_Borrowed(file), "w"), "zstd")

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._file.fileno()

    def write(self, data: Any) -> int:
        if self._gzip is None:
            self._zstd.write(bytes(data))
        else:
            self._put(self._gzip.compress(data))
        return len(data)

    def flush(self) -> None:
        if self._ended:
            return
        if self._gzip is None:
            self._zstd.flush()
        else:
            self._put(self._gzip.flush(zlib.Z_SYNC_FLUSH))

    def close(self) -> None:
        if self._ended:
            return
        self._ended = True
        try:
            if self._gzip is None:
                self._zstd.close()
            else:
                self._put(self._gzip.flush())
        finally:
            self._file.close()
            super().close()

    def _put(self, packed: bytes) -> None:
        left = memoryview(packed)
        while left:
            left = left[self._file.write(left) :]


def refuse_packed(path: str, format: str) -> None:
    """Raise BadLog for a format that cannot be packed."""
    if format in NEEDS_PATH:
        raise BadLog(
            f"{path}: {format} cannot be read or written packed; unpack it, or choose another format"
        )
