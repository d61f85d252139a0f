"""Loads a campaign from a Python file, here or in a worker on another machine: the text of the file is passed on."""

from __future__ import annotations

import linecache
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from canwire.campaigns.campaign import Campaign
from canwire.errors import BadValue


@dataclass(frozen=True)
class Script:
    """The text of a file with campaigns, and the name of the selected one ("" if the file contains only one)."""

    path: str
    text: str
    name: str = ""

    @classmethod
    def read(cls, path: str | Path, name: str = "") -> Script:
        """Read the file. Raises OSError, and BadValue if it is not text."""
        try:
            return cls(str(path), Path(path).read_text(encoding="utf-8"), name)
        except UnicodeDecodeError as error:
            raise BadValue(f"{path}: not a Python file ({error})") from None

    def load(self) -> Campaign:
        """Run the file's text and find the campaign. Raises BadValue, and any exception of the file itself."""
        module = ModuleType(f"canwire_campaign_{Path(self.path).stem}")
        module.__file__ = self.path
        sys.modules[module.__name__] = module
        linecache.cache[self.path] = (len(self.text), None, self.text.splitlines(True), self.path)
        try:
            code = compile(self.text, self.path, "exec")
        except SyntaxError as error:
            raise BadValue(f"{self.path}, line {error.lineno}: {error.msg}") from None
        exec(code, module.__dict__)
        return self._chosen({key: one for key, one in vars(module).items() if isinstance(one, Campaign)})

    def _chosen(self, found: dict[str, Campaign]) -> Campaign:
        names = ", ".join(found) or "none; a campaign is a function under @campaign(...)"
        if not self.name and len(found) == 1:
            return next(iter(found.values()))
        if self.name not in found:
            what = f"no campaign {self.name!r}" if self.name or not found else "several campaigns, say which"
            raise BadValue(f"{self.path}: {what}: it has {names}")
        return found[self.name]


def script_of(campaign: Campaign | str | Path, name: str = "") -> Script:
    """The file that contains a campaign. Raises OSError, BadValue."""
    if isinstance(campaign, Campaign):
        return Script.read(campaign.source, campaign.name)
    return Script.read(campaign, name)
