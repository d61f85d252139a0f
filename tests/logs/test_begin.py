"""A log that cannot begin leaves nothing behind."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from canwire import ExtraMissing, create_log


def test_where_a_library_is_missing_no_file_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ExtraMissing, match="pyarrow"):
        create_log(tmp_path / "log.parquet")
    assert list(tmp_path.iterdir()) == []
