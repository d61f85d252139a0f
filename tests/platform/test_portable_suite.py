"""Hub tests once more in the portable variant: a part; `.ci/run` has more, the command in docs/platforms.md all."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from canwire.platform import PORTABLE
from tests.cold import PYTEST

ROOT = Path(__file__).parent.parent.parent
PART = (
    "tests/hub/links/network/test_programs.py",
    *(
        f"tests/hub/links/network/test_faults.py::test_{one}"
        for one in (
            "a_frozen_client_holds_nobody_up_and_goes_on",
            "a_slow_client_loses_its_own_frames_and_holds_nobody_up",
            "kill_9_of_a_client_in_mid_batch_gives_everything_back",
        )
    ),
    "tests/hub/links/test_links.py",
    "tests/hub/links/test_loopback.py",
    "tests/hub/handles/test_waiting.py",
    "tests/hub/test_kills.py",
    "tests/platform/test_ticks.py",
    *(
        f"tests/python_can/test_bus.py::test_{one}"  # where waiting, files to wait for and a hub's end come in
        for one in (
            "programs_on_one_line_hear_each_other",
            "a_notifier_with_an_event_loop",
            "backpressure",
            "unplugged_and_hub_lost",
            "shutdown",
        )
    ),
)
ALIKE = (
    "--deselect=tests/hub/links/network/test_programs.py::test_what_cannot_be_offered_is_refused",
)  # in both variants: no hub runs
LONGEST_S = 1800  # beside other work; ten seconds by itself


@pytest.mark.long
@pytest.mark.conforms("N-19")
@pytest.mark.skipif(PORTABLE, reason="this is that run")
@pytest.mark.timeout(2 * LONGEST_S)
@pytest.mark.usefixtures("python_can_without_mf4")
def test_the_links_and_handles_of_hubs(tmp_path: Path) -> None:
    environment = os.environ | {"CANWIRE_PLATFORM": "portable", "CANWIRE_TESTS_RUNTIME": str(tmp_path)}
    tmp_path.chmod(0o700)
    command = [*PYTEST, "-n", "0", *PART, *ALIKE]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    assert " passed" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["canwire.lock"], "memory was left behind"
