"""The steps of `canwire uds`: services of ISO 14229-1 by name, and their output."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from canwire import BadValue
from canwire.commands.transport.flash import flash
from canwire.commands.transport.line import load

_SESSIONS = {"default": 1, "programming": 2, "extended": 3, "safety": 4}
_RESETS = {"hard": 1, "key": 2, "soft": 3}
_ROUTINES = {"start": 1, "stop": 2, "result": 3}
_ALL_DTCS = 0xFFFFFF


class Service(NamedTuple):
    """A row of the table: syntax, name in the standard, help text, and the number of words that it `needs`."""

    words: str
    service: str
    help: str
    needs: int
    work: Callable[[Any, Sequence[str]], None]


class Step(NamedTuple):
    """A step of a command line."""

    text: str
    service: Service
    words: list[str]

    def done(self, client: Any) -> None:
        """Send the request to the ECU; raises the errors of udsoncan."""
        self.service.work(client, self.words)


def parsed_steps(texts: Sequence[str]) -> list[Step]:
    """Return all steps, checked; raises BadValue with similar names."""
    found = []
    for text in texts:
        name, *words = text.split(":")
        key = next((key for key, one in STEPS.items() if name.lower() in (key, one.service.lower())), None)
        if key is None:
            near = difflib.get_close_matches(name.lower(), STEPS, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(STEPS)}"
            raise BadValue(f"{text}: no service {name!r}; {hint}")
        service = STEPS[key]
        if len(words) < service.needs:
            raise BadValue(f"{text}: it is {service.words}")
        _check(key, text, words)
        found.append(Step(text, service, words))
    return found


def plain_codec() -> Any:
    """Return a codec that leaves the data of every identifier as bytes."""
    udsoncan = load("udsoncan")

    class Plain(udsoncan.DidCodec):  # type: ignore[name-defined, misc]
        def encode(self, data: bytes) -> bytes:
            return data

        def decode(self, payload: bytes) -> bytes:
            return payload

        def __len__(self) -> int:
            raise self.ReadAllRemainingData

    return Plain


def _check(key: str, text: str, words: Sequence[str]) -> None:
    """Raise BadValue for errors in a step that can be found before a request is sent to the ECU."""
    named = {"session": _SESSIONS, "reset": _RESETS, "routine": _ROUTINES}.get(key)
    hexes = {"read": words[:1], "write": words[:2], "routine": words[1:3], "raw": words[:1], "unlock": words[:1],
             "dtc": words[:1], "clear": words[:1], "flash": words[1:2]}.get(key, [])  # fmt: skip
    for word in hexes:
        try:
            bytes.fromhex(word if key in ("write", "raw") or len(word) % 2 == 0 else f"0{word}")
        except ValueError:
            raise BadValue(f"{text}: {word!r} is no number in hex") from None
    if named is not None and words and words[0] not in named:
        try:
            int(words[0], 16)
        except ValueError:
            raise BadValue(f"{text}: {', '.join(named)}, or a number in hex") from None


def _shown(data: bytes) -> str:
    text = data.decode("ascii", "replace")
    readable = data and all(32 <= byte < 127 for byte in data)
    return data.hex(" ").upper() + (f'  "{text}"' if readable else "")


def _number(names: dict[str, int], word: str) -> int:
    return names[word] if word in names else int(word, 16)


def _read(client: Any, words: Sequence[str]) -> None:
    id = int(words[0], 16)
    values = client.read_data_by_identifier(id).service_data.values
    print(f"{id:04X}: {_shown(values[id])}")


def _write(client: Any, words: Sequence[str]) -> None:
    id = int(words[0], 16)
    client.write_data_by_identifier(id, bytes.fromhex(words[1]))
    print(f"{id:04X}: written")


def _session(client: Any, words: Sequence[str]) -> None:
    number = _number(_SESSIONS, words[0])
    client.change_session(number)
    print(f"session {number}")


def _reset(client: Any, words: Sequence[str]) -> None:
    client.ecu_reset(_number(_RESETS, words[0] if words else "hard"))
    print("reset")


def _present(client: Any, words: Sequence[str]) -> None:
    del words
    client.tester_present()
    print("present")


def _unlock(client: Any, words: Sequence[str]) -> None:
    if client.config["security_algo"] is None:
        raise BadValue(f"unlock:{words[0]}: --key says how a seed becomes a key")
    client.unlock_security_access(int(words[0], 16))
    print(f"unlocked, level {words[0]}")


def _dtc(client: Any, words: Sequence[str]) -> None:
    mask = int(words[0], 16) if words else 0xFF
    found = client.get_dtc_by_status_mask(mask).service_data.dtcs
    for one in found:
        print(f"{one.id:06X}  status {one.status.get_byte_as_int():02X}")
    print(f"{len(found)} faults")


def _clear(client: Any, words: Sequence[str]) -> None:
    client.clear_dtc(int(words[0], 16) if words else _ALL_DTCS)
    print("faults cleared")


def _routine(client: Any, words: Sequence[str]) -> None:
    control, id = _number(_ROUTINES, words[0]), int(words[1], 16)
    data = bytes.fromhex(words[2]) if len(words) > 2 else None
    told = client.routine_control(id, control, data).service_data.routine_status_record
    print(f"routine {id:04X}: {words[0]}{f', {_shown(told)}' if told else ''}")


def _raw(client: Any, words: Sequence[str]) -> None:
    """Send the bytes as they are; print the answer, positive or negative."""
    connection = client.conn
    connection.empty_rxqueue()
    connection.send(bytes.fromhex(words[0]))
    print(connection.wait_frame(timeout=client.config["p2_timeout"], exception=True).hex(" ").upper())


STEPS = {
    "read": Service("read:ID", "ReadDataByIdentifier", "print the data of this identifier", 1, _read),
    "write": Service("write:ID:HEX", "WriteDataByIdentifier", "write these bytes", 2, _write),
    "session": Service(
        "session:NAME", "DiagnosticSessionControl", ", ".join(_SESSIONS) + ", or hex", 1, _session
    ),
    "reset": Service("reset[:KIND]", "ECUReset", ", ".join(_RESETS) + ", or hex", 0, _reset),
    "present": Service("present", "TesterPresent", "check that the ECU answers", 0, _present),
    "unlock": Service("unlock:LEVEL", "SecurityAccess", "with seed and key, see --key", 1, _unlock),
    "dtc": Service("dtc[:MASK]", "ReadDTCInformation", "print faults by status mask (FF)", 0, _dtc),
    "clear": Service("clear[:GROUP]", "ClearDiagnosticInformation", "clear faults (FFFFFF: all)", 0, _clear),
    "routine": Service("routine:WHAT:ID[:HEX]", "RoutineControl", ", ".join(_ROUTINES), 2, _routine),
    "flash": Service(
        "flash:FILE:ADDRESS", "RequestDownload", "then TransferData, RequestTransferExit", 2, flash
    ),
    "raw": Service("raw:HEX", "any", "print the bytes of the answer", 1, _raw),
}
