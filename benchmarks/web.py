"""What the page costs and how far behind the bus it is: `canwire web` with a viewer in Debian's chromium.

python benchmarks/web.py                     20 s at 5,000 frames/s
python benchmarks/web.py --seconds 600       the ten minutes of the issue

Each frame carries the time at which it was queued; the page tells, whenever it has drawn, how old the newest row is.
The hub's cost of a viewer is its processor time with one less that without, over the same traffic.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from playwright.sync_api import sync_playwright

import canwire
from canwire import ChannelMode, Frame, WantedMode

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]  # fmt: skip
BIT_RATE = 1_000_000
BATCH_S = 0.004  # between two batches
ALONE_S = 60.0  # the longest time for the hub without viewers
WATCH = """() => {
  window.ages = [];
  document.addEventListener("drawn", ({ detail: { rows, last } }) => {
    if (!rows.has(last) || rows.number(last) === window.newest || !rows.frame(last)) return;
    window.newest = rows.number(last);
    const at = rows.at(last) + 16;
    const stamp = rows.view.getUint32(at, true) * 1e-6 + rows.view.getUint32(at + 4, true);
    window.ages.push((performance.timeOrigin + performance.now()) / 1000 - stamp);
  });
}"""


@contextmanager
def process(*words: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    command = [sys.executable, "-m", "canwire", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as started:
        assert started.stdout is not None
        try:
            yield started, started.stdout.readline()
        finally:
            started.terminate()


def stamped() -> Frame:
    """Seconds and microseconds of now as 32-bit words."""
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    return Frame(0x123, (nanoseconds // 1000).to_bytes(4, "little") + seconds.to_bytes(4, "little"))


def drive(channel: canwire.HubChannel, rate: int, seconds: float) -> int:
    """Queue frames at this rate; how many."""
    begin, sent = time.monotonic(), 0
    while (passed := time.monotonic() - begin) < seconds:
        while sent < passed * rate:
            channel.send(stamped(), timeout=5)
            sent += 1
        time.sleep(BATCH_S)
    return sent


def processor_s(pid: int) -> float:
    """User and system time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def browser_s() -> dict[str, float]:
    """Processor time of chromium's processes that this program started, by their kind ("" is the browser itself)."""
    found: dict[str, float] = {}
    ours = {os.getpid()}
    for path in sorted(Path("/proc").glob("[0-9]*"), key=lambda path: int(path.name)):
        with suppress(OSError):  # it has just ended
            fields = (path / "stat").read_text().rpartition(")")[2].split()
            command = (path / "cmdline").read_text()
            if int(fields[1]) not in ours:
                continue
            ours.add(int(path.name))
            if "chromium" in command.partition(" ")[0]:
                kind = match[1] if (match := re.search(r"--type=([\w-]+)", command)) else ""
                found[kind] = found.get(kind, 0) + processor_s(int(path.name))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rate", type=int, default=5000, help="frames a second (%(default)s)")
    parser.add_argument(
        "--seconds", type=float, default=20.0, help="with viewers, and up to a minute without (%(default)s)"
    )
    parser.add_argument(
        "--viewers",
        type=int,
        default=1,
        help="browsers that look at the same time, the third one slow (%(default)s)",
    )
    arguments = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as home,
        process("serve", "--socket", f"{home}/hub") as (served, _),
        canwire.connect(f"{home}/hub", name="benchmark") as hub,
    ):
        lines = canwire.find_lines(hub, "can0", "CAN")[:2]
        for line in lines:
            canwire.start_line(hub, line, WantedMode(BIT_RATE).mode(line.info.capabilities))
        channel = hub.open_channel(lines[0].board.id, lines[0].line)
        channel.set_up(ChannelMode(receive=8, transmit=1024))
        channel.activate()
        before = processor_s(served.pid)
        alone_s = min(arguments.seconds, ALONE_S)
        drive(channel, arguments.rate, alone_s)
        alone = (processor_s(served.pid) - before) * arguments.seconds / alone_s
        measure(served.pid, channel, f"{home}/hub", arguments, alone)


def measure(
    pid: int, channel: canwire.HubChannel, socket: str, arguments: argparse.Namespace, alone: float
) -> None:
    """The same traffic with the page open."""
    with process("web", "--hub", socket) as (server, printed), sync_playwright() as started:
        browser = started.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        begin = time.monotonic()
        page.goto(printed.split()[-1])
        page.goto(printed.split()[-1].partition("?")[0] + "trace")
        paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
        page.locator("body[data-listening=yes]").wait_for()
        print(
            f"two pages opened in {time.monotonic() - begin:.2f} s; first paint of the trace after {paint:.0f} ms"
        )
        page.evaluate(WATCH)
        others = [browser.new_page() for _ in range(arguments.viewers - 1)]
        for other in others:
            other.goto(printed.split()[-1])  # for its cookie
            other.goto(page.url)
            other.locator("body[data-listening=yes]").wait_for()
        for slow in others[1:2]:  # the third one's processor is six times slower
            slow.context.new_cdp_session(slow).send("Emulation.setCPUThrottlingRate", {"rate": 6})
        hub_before, server_before, shown_before = processor_s(pid), processor_s(server.pid), browser_s()
        sent = drive(channel, arguments.rate, arguments.seconds)
        hub_s, server_s = processor_s(pid) - hub_before, processor_s(server.pid) - server_before
        shown_s = {kind: value - shown_before.get(kind, 0) for kind, value in browser_s().items()}
        page.wait_for_timeout(1000)
        ages = sorted(age * 1000 for age in page.evaluate("window.ages"))
        lost, late = (int(page.locator(f"#{name}").inner_text()) for name in ("lost", "late"))
        log = page.request.get(page.url + "/log?lines=HW000001:0").text().count("\n")
        heap = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
        browser.close()
    print(
        f"{sent} frames in {arguments.seconds:g} s ({sent / arguments.seconds:.0f}/s), lost {lost}, late {late}"
    )
    print(f"rows in the log: {log}")
    print(f"pictures drawn: {len(ages) / arguments.seconds:.0f}/s")
    middle, late = statistics.median(ages), ages[int(len(ages) * 0.95)]
    print(f"newest row's age when drawn: p50 {middle:.0f} ms, p95 {late:.0f} ms")
    percent = 100 / arguments.seconds
    print(f"hub: {alone * percent:.1f} % of a core without a viewer, {hub_s * percent:.1f} % with one")
    told = ", ".join(f"{kind or 'browser'} {value * percent:.0f} %" for kind, value in shown_s.items())
    print(f"chromium, of a core: {told}")
    print(f"server: {server_s * percent:.1f} % of a core; the page's JavaScript memory {heap:.0f} MB")


if __name__ == "__main__":
    main()
