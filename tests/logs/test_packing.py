"""Logs packed by gzip and Zstandard: read, written, growing, cut."""

from __future__ import annotations

import gzip
import io
from pathlib import Path

import pytest

from canwire import BadLog, create_log, open_log
from canwire.commands import main
from tests.logs.contents import some

FORMATS = [".log", ".asc", ".csv", ".trc", ".blf", ".pcapng"]


@pytest.mark.parametrize("packing", [".gz", ".zst"])
@pytest.mark.parametrize("suffix", FORMATS)
def test_there_and_back(tmp_path: Path, suffix: str, packing: str) -> None:
    if packing == ".zst":
        pytest.importorskip("pyarrow")
    plain, packed = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}{packing}"
    for path in (plain, packed):
        with create_log(path) as log:
            log.write_many(some(300))
    with open_log(plain) as one, open_log(packed) as other:
        expected = list(one)
        assert list(other) == expected
        assert list(other) == expected  # rewound
        assert other.fault_count == one.fault_count
    assert packed.stat().st_size < plain.stat().st_size


def test_gzip_s_own_file_in_several_members(tmp_path: Path) -> None:
    path = tmp_path / "cat.log.gz"
    path.write_bytes(gzip.compress(b"(1.000000) can0 123#11\n") + gzip.compress(b"(2.000000) can0 124#\n"))
    with open_log(path) as log:
        assert [entry.timestamp_ns for entry in log] == [10**9, 2 * 10**9]
        assert not log.faults


@pytest.mark.parametrize("packing", [".gz", ".zst"])
def test_what_was_flushed_can_be_read_while_it_grows(tmp_path: Path, packing: str) -> None:
    if packing == ".zst":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"grows.log{packing}"
    with create_log(path) as log:
        log.write_many(some(100))
        log.flush()
        with open_log(path) as growing:
            found = sum(len(batch) for batch in growing.batches())
            assert found == log.count
            assert "grows" in str(growing.faults[-1])


def test_a_cut_one_is_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "cut.log.gz"
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb") as packed:
        packed.write(
            b"".join(b"(%d.000000) can0 %03X#%016X\n" % (k, k % 2048, k * k * k) for k in range(5000))
        )
    path.write_bytes(buffer.getvalue()[: len(buffer.getvalue()) // 2])
    with open_log(path) as log:
        assert sum(1 for _ in log) > 1000
        assert "cut" in str(log.faults[-1])


def test_formats_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(BadLog, match="sqlite cannot be read or written packed"):
        create_log(tmp_path / "a.db.gz")


def test_by_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = tmp_path / "a.log", tmp_path / "b.asc.gz"
    first.write_text("(1.000000) can0 123#11\n")
    assert main(["convert", str(first), str(second)]) == 0
    assert "1 entries from candump to asc" in capsys.readouterr().out
    assert gzip.decompress(second.read_bytes()).startswith(b"date ")
