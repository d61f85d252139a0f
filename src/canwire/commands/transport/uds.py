"""`canwire uds`: send UDS requests (ISO 14229) to an ECU, step by step, with udsoncan over ISO-TP.

canwire uds can0 read:F190                        ReadDataByIdentifier, to 7E0; the answer comes from 7E8
canwire uds can0 session:extended unlock:1 write:0101:6F6B --key invert
canwire uds can0 dtc clear reset:hard             print faults, clear them, reset the ECU
canwire uds can0 routine:start:FF00 routine:result:FF00
canwire uds can0 session:programming unlock:1 flash:image.bin:08000000 --key keys.py:key
canwire uds can0 raw:1902FF                       send these bytes unchanged

Steps run in their order on one connection. Each has a short name and a name in the standard:
{steps}

--key names the function that calculates a key from a seed: invert, xor:5A, or FILE.py:FUNCTION, which is called with
level and seed. A negative response is printed by name. It ends the command with status 1, as a timeout does.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import Any

from canwire.commands.console import complain
from canwire.commands.shared_hub import connected
from canwire.commands.transport.keys import key_by
from canwire.commands.transport.line import IsoTpLine, add_transport_arguments, load
from canwire.commands.transport.steps import STEPS, parsed_steps

_WIDEST = 34
__doc__ = (__doc__ or "").format(
    steps="\n".join(f"  {f'{one.words} ({one.service})':<{_WIDEST}} {one.help}" for one in STEPS.values())
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_transport_arguments(parser)
    parser.add_argument(
        "steps", nargs="+", metavar="STEP", help="a step as listed above: read:F190, session:extended"
    )
    parser.add_argument(
        "--key", metavar="HOW", help="calculate keys from seeds by: invert, xor:HEX, FILE.py:FUNCTION"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the steps; 1 if the ECU refuses one. Raises BadValue, HubError, ExtraMissing, OSError."""
    steps = parsed_steps(arguments.steps)
    key = None if arguments.key is None else key_by(arguments.key)
    exceptions = load("udsoncan").exceptions
    with ExitStack() as closing:
        line = IsoTpLine(connected(arguments, "uds", closing), arguments, closing)
        client = closing.enter_context(_client(line, arguments.timeout, key))
        for step in steps:
            try:
                step.done(client)
            except exceptions.NegativeResponseException as error:
                code = error.response.code
                complain(f"{step.text}: {error.response.code_name} (NRC {code:02X})")
                return 1
            except exceptions.TimeoutException:
                complain(f"{step.text}: {_why(line, arguments)}")
                return 1
            except (exceptions.InvalidResponseException, exceptions.UnexpectedResponseException) as error:
                complain(f"{step.text}: {error}")
                return 1
    return 0


def _client(line: IsoTpLine, timeout_s: float, key: Any) -> Any:
    """Return udsoncan's client, with data of every identifier as plain bytes."""
    load("udsoncan")
    client, connections = load("udsoncan.client"), load("udsoncan.connections")
    from canwire.commands.transport.steps import plain_codec

    line.layer.stop()  # udsoncan starts it itself
    config = {
        **load("udsoncan.configs").default_client_config,
        "data_identifiers": {"default": plain_codec()},
        "request_timeout": None,
        "p2_timeout": timeout_s,
        "use_server_timing": False,
        "security_algo": None if key is None else (lambda level, seed, params: key(level, seed)),
    }
    return client.Client(connections.PythonIsoTpConnection(line.layer), config=config)


def _why(line: IsoTpLine, arguments: argparse.Namespace) -> str:
    if line.errors:
        return str(line.errors[-1])
    if line.sending.result():
        return "the request was not sent"
    return f"no answer from {arguments.rx} in {arguments.timeout:g} s"
