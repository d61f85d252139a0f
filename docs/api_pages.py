"""Makes docs/api/: a page for each topic of topics.toml, which Sphinx fills with what the source says of each name.

conf.py calls `write` before Sphinx reads its pages; they are not kept in the repository.
"""

from __future__ import annotations

import enum
import inspect
import re
import tomllib
from pathlib import Path
from typing import NamedTuple

import canwire

HERE = Path(__file__).resolve().parent
FOLDER = HERE / "api"
INDEX = """The library by topic
====================

Everything public is a name of ``canwire``; nothing deeper is. The examples import every name from ``canwire``, and
use objects that are made before: ``lab``, its buses ``bus`` (can0) and ``lin``, and ``hub``. The interfaces of vendors
have pages of their own, such as :doc:`/porting-vci`.

.. toctree::
   :maxdepth: 1

"""


class Topic(NamedTuple):
    """A page: its file's name, its heading, the public names on it, a doctest."""

    page: str
    title: str
    names: list[str]
    example: str


def topics() -> list[Topic]:
    """In the order in which the index lists them."""
    tables = tomllib.loads((HERE / "topics.toml").read_text(encoding="utf-8"))["topic"]
    return [Topic(one["page"], one["title"], one["names"].split(), one["example"]) for one in tables]


def text_of(topic: Topic) -> str:
    """The page: heading, example, and a directive for each name."""
    code = "".join(f"   {line}".rstrip() + "\n" for line in topic.example.strip().splitlines())
    parts = [f"{topic.title}\n{'=' * len(topic.title)}\n", f".. code-block:: pycon\n\n{code}"]
    return "\n".join([*parts, *map(directive, topic.names)])


def directive(name: str) -> str:
    """What Sphinx is to write of a name: of a class its members that have a text, and those of what it is made from."""
    found = getattr(canwire, name)
    if not isinstance(found, type):
        return f".. autofunction:: canwire.{name}\n" if inspect.isroutine(found) else constant(name, found)
    if issubclass(found, BaseException):
        return f".. autoexception:: canwire.{name}\n   :show-inheritance:\n"
    if issubclass(found, enum.Enum):
        return f".. autoclass:: canwire.{name}\n   :members:\n   :undoc-members:\n"
    return f".. autoclass:: canwire.{name}\n   :members:\n   :inherited-members: {outside(found)}\n"


def constant(name: str, value: object) -> str:
    """A constant with its value and the comment behind it in the source; raises ValueError if it has none."""
    if name == "__version__":
        return f".. py:data:: canwire.{name}\n\n   The version of the package.\n"
    source = Path(canwire.__file__).parent / f"{canwire._PLACES[name].replace('.', '/')}.py"
    comment = re.search(
        rf"^{name} = [^#]+?# (.+?)(?:  # fmt: skip)?$", source.read_text("utf-8"), re.MULTILINE
    )
    if comment is None:
        raise ValueError(f"{source}: {name} has no comment that says what it is")
    return f".. py:data:: canwire.{name}\n   :value: {value!r}\n\n   {comment[1].replace('`', '``')}\n"


def outside(kind: type) -> str:
    """Classes that are not canwire's, whose members are not shown."""
    return ", ".join(base.__name__ for base in kind.__mro__ if not base.__module__.startswith("canwire"))


def write() -> None:
    """All pages; files that are as they should be stay, so that Sphinx reads again what has changed."""
    FOLDER.mkdir(exist_ok=True)
    listed = topics()
    pages = {topic.page: text_of(topic) for topic in listed}
    pages["index"] = INDEX + "".join(f"   {topic.page}\n" for topic in listed)
    for old in FOLDER.glob("*.rst"):
        if old.stem not in pages:
            old.unlink()
    for name, text in pages.items():
        path = FOLDER / f"{name}.rst"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
