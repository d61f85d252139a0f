"""What stands in a page between fences, and how it is run: Python in one namespace, commands in one shell."""

from __future__ import annotations

import contextlib
import io
import os
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from tests import warm
from tests.cold import PYTEST

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[^>]*?) -->\n)?```(?P<language>\w+)\n(?P<text>.*?)^```\n", re.MULTILINE | re.DOTALL
)
LONG_S = 240  # after which a page of forty commands will never end, however busy the machine is
UNTIL_IT_SERVES = (  # without a hub `canwire devices` shows what a program has by itself: an empty address
    """until canwire devices --json 2>/dev/null | grep -q '"hub": "/'; do kill -0 "$!" || exit 99; done"""
)


class Block(NamedTuple):
    """One block; `mark` is what a comment in front of it says."""

    mark: str
    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [Block(found["mark"] or "", found["language"], found["text"]) for found in FENCE.finditer(text)]


def run_python(page: Path) -> int:
    """Every unmarked Python block, each in the namespace of those before it; what it prints is the text block below it.

    Returns how many ran. AssertionError shows both where they differ.
    """
    space: dict[str, Any] = {"__name__": page.stem}
    listed = [block for block in blocks(page) if not block.mark]
    ran = 0
    for block, below in zip(listed, [*listed[1:], Block("", "", "")], strict=True):
        if block.language != "python":
            continue
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(block.text, f"<{page.name}>", "exec"), space)
        expected = below.text if below.language == "text" else ""
        assert output.getvalue() == expected, f"{page.name}:\n{block.text}\nprinted:\n{output.getvalue()}"
        ran += 1
    return ran


def commands(page: Path) -> str:
    """The lines behind `$ ` of the page's console blocks, as a script; what goes on behind a `&` is waited for."""
    lines: list[str] = []
    for block in blocks(page):
        if block.language != "console":
            continue
        for line in block.text.splitlines():
            if line.startswith("$ "):
                lines.append(line[2:])
                if re.match(r"canwire serve\b.*&$", line[2:]):
                    lines.append(UNTIL_IT_SERVES)
                if re.match(r"canwire serve\b.* --network\b.*&$", line[2:]):
                    lines.append(
                        'until canwire devices --network >/dev/null 2>&1; do kill -0 "$!" || exit 99; done'
                    )
    return "\n".join(lines)


def run_console(page: Path, home: Path) -> str:
    """The page's commands in one shell, in the repository, with a runtime directory of its own; what they printed.

    What they write into the temporary directory goes into `home`.

    AssertionError if one fails. What is left running in the background is ended.
    """
    runtime = home / "runtime"
    runtime.mkdir(mode=0o700)
    tools = home / "bin"
    tools.mkdir()
    warm.write_script(tools / "canwire")
    environment = {name: value for name, value in os.environ.items() if name != "CANWIRE_HUB"}
    environment |= {
        "PATH": f"{tools}{os.pathsep}{environment['PATH']}",
        "XDG_RUNTIME_DIR": str(runtime),
        "XDG_STATE_HOME": str(home / "state"),
        "TMPDIR": str(home),
    }
    with ended(
        subprocess.Popen(
            ["bash", "-e", "-c", commands(page).replace("/tmp/", f"{home}/")],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
    ) as shell:
        assert shell.wait(LONG_S) == 0, group_output(shell)
        return group_output(shell)


def run_tests(home: Path) -> str:
    """pytest in the folder into which a page's tests were written, with no plugin but canwire's; what it printed.

    AssertionError if one fails. README's test runs with all that are installed, as a user's does.
    """
    command = [*PYTEST, "-p", "canwire.pytest_plugin", "."]
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    ended = warm.run(command, cwd=home, env=environment, capture_output=True, text=True, timeout=LONG_S)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return str(ended.stdout)


def group_output(shell: subprocess.Popen[str]) -> str:
    """All that it and what it left running printed."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(shell.pid, signal.SIGTERM)
    assert shell.stdout is not None
    return shell.stdout.read()


@contextlib.contextmanager
def ended(shell: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """Nothing of it is left afterwards."""
    try:
        yield shell
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)
        shell.wait(LONG_S)
        assert shell.stdout is not None
        shell.stdout.close()
