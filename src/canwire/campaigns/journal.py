"""The journal of a campaign that is not complete: a file beside its table with each run that is done."""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import BinaryIO

from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun
from canwire.errors import BadValue
from canwire.version import __version__

_FORMAT = 1


class Journal:
    """One line of JSON that identifies the campaign, then one line per run. It outlives its program.

    An existing file is continued: `runs` contains its runs by number. An incomplete last line is cut off, and its run
    is played again. Raises OSError, and BadValue if the file belongs to another campaign or another program writes it.
    """

    def __init__(self, path: Path, script: Script, name: str, seed: int) -> None:
        self.path = path
        self.runs: dict[int, CampaignRun] = {}
        heading = {
            "journal": _FORMAT,
            "canwire": __version__,
            "campaign": name,
            "seed": seed,
            "script": hashlib.sha256(script.text.encode()).hexdigest(),
        }
        self._file: BinaryIO = path.open("a+b")
        try:
            self._lock()
            self._read(heading)
        except BaseException:
            self._file.close()
            raise

    def write(self, runs: list[CampaignRun]) -> None:
        """Append these runs. On return the operating system has them: killing this program loses none of them."""
        self._file.write(b"".join(_line(asdict(run)) for run in runs))
        self._file.flush()

    def close(self, over: bool) -> None:
        """Close the file, and remove it if the campaign is `over`: the same command then plays everything again."""
        self._file.close()
        if over:
            self.path.unlink(missing_ok=True)

    def _lock(self) -> None:
        """Lock the file against other programs; on Windows it is not locked, so two programs could use one journal."""
        if sys.platform == "win32":
            return
        import fcntl

        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BadValue(
                f"{self.path}: another program plays a campaign with these results: wait for it, or name another file"
            ) from None

    def _read(self, heading: dict[str, object]) -> None:
        self._file.seek(0)
        whole, newline, _ = self._file.read().rpartition(b"\n")
        self._file.truncate(len(whole) + len(newline))
        lines = whole.splitlines()
        if not lines:
            self._file.write(_line(heading))
            self._file.flush()
            return
        self._check(lines[0], heading)
        for number, line in enumerate(lines[1:], 2):
            try:
                run = CampaignRun(**json.loads(line))
            except (ValueError, TypeError) as error:
                raise BadValue(
                    f"{self.path}, line {number}: not a run of a campaign ({error}): remove the file"
                ) from None
            self.runs[run.number] = run

    def _check(self, line: bytes, heading: dict[str, object]) -> None:
        try:
            found = json.loads(line)
        except ValueError:
            found = None
        if not isinstance(found, dict) or "journal" not in found:
            raise BadValue(f"{self.path}: not a journal of a campaign: remove it, or name another file")
        other = [key for key, value in heading.items() if found.get(key) != value]
        if other:
            raise BadValue(
                f"{self.path} has runs of a campaign that was not over, with another "
                f"{', another '.join(other)}: remove it to start from the beginning, or name another file"
            )


def journal_of(results: str | Path) -> Path:
    """The path of the journal, beside the table."""
    return Path(f"{results}.journal")


def _line(content: dict[str, object]) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode() + b"\n"
