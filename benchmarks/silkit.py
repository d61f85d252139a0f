"""SIL Kit's participants, for benchmarks/lockstep.py: each has a step of 1 ms of the time that they keep together.

They run in an interpreter of their own, which has `silkit-py` (Python 3.12 and later): `pip install silkit-py`.
"""

from __future__ import annotations

import socket
import subprocess
from contextlib import ExitStack

_PARTICIPANT = """
import asyncio, sys, time
import SilKit_py as silkit

name, uri, steps = sys.argv[1], sys.argv[2], int(sys.argv[3])
quiet = silkit.participant_configuration_from_String('{"Logging": {"Sinks": []}}')
participant = silkit.create_participant(quiet, name, uri)
life = participant.create_lifecycle_service(silkit.LifecycleConfiguration(silkit.OperationMode.Coordinated))
time_sync = life.create_time_sync_service()
began_ns, began_s = 100_000_000, 0.0

def step(now_ns, span_ns):
    global began_s
    if now_ns == began_ns:
        began_s = time.perf_counter()
    if now_ns == began_ns + steps * 1_000_000:
        print(steps / (time.perf_counter() - began_s), flush=True)
        if name == "p0":
            life.stop("all steps are done")

time_sync.set_simulation_step_handler(step, 1_000_000)

async def main():
    await life.start_lifecycle()

asyncio.run(main())
"""
_FOLDER = "import SilKit_py, pathlib; print(pathlib.Path(SilKit_py.__file__).parent / 'bin')"


def steps_a_second(python: str, participants: int, steps: int) -> float:
    """As the first participant measures it, with a registry and a controller of their own."""
    tools = subprocess.run([python, "-c", _FOLDER], check=True, capture_output=True, text=True).stdout.strip()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        uri = f"silkit://127.0.0.1:{listener.getsockname()[1]}"
    names = [f"p{number}" for number in range(participants)]
    with ExitStack() as stack:
        registry = _started(stack, [f"{tools}/sil-kit-registry", "-u", uri])
        assert registry.stdout is not None
        while "Press" not in registry.stdout.readline():
            assert registry.poll() is None, "the registry does not start"
        programs = [_started(stack, [python, "-c", _PARTICIPANT, name, uri, str(steps)]) for name in names]
        _started(stack, [f"{tools}/sil-kit-system-controller", "-u", uri, *names])
        first = programs[0].stdout
        assert first is not None
        return float(first.readline())


def _started(stack: ExitStack, command: list[str]) -> subprocess.Popen[str]:
    process = stack.enter_context(
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    )
    stack.callback(process.kill)
    return process
