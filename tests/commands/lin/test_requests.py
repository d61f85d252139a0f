"""`canwire lin slave`, `identify`, `assign`, `save`, `request`: node configuration on lines of a plain hub."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire import BadValue, Hub, LinControl, LinFrame, LinMode, LinNodeAttributes, LinProduct, connect
from canwire.commands import main
from canwire.values.lin.requests import (
    assign_frame_ids_request,
    assign_nad_request,
    lin_refusal,
    read_by_identifier_request,
    save_configuration_request,
)
from tests.cases import each
from tests.commands.lin.test_verb import Served, errors, served, start, texts

pytestmark = pytest.mark.conforms("N-47")

__all__ = ["served", "start"]  # fixtures
DOOR = Path(__file__).parents[3] / "examples" / "door.ldf"


def test_payloads() -> None:
    """LIN 2.2A 4.2.3."""
    assert read_by_identifier_request().hex(" ") == "b2 00 ff 7f ff ff"
    assert read_by_identifier_request(1, 0x1234, 0x5678).hex(" ") == "b2 01 34 12 78 56"
    assert assign_nad_request(0x22).hex(" ") == "b0 ff 7f ff ff 22"
    assert assign_frame_ids_request(0, [0x10, -1, None]).hex(" ") == "b7 00 50 ff 00 ff"
    assert save_configuration_request() == b"\xb6"
    for wrong in (
        lambda: read_by_identifier_request(64),
        lambda: assign_nad_request(0),
        lambda: assign_nad_request(1, 0x8000),
        lambda: assign_frame_ids_request(0, []),
        lambda: assign_frame_ids_request(0, [1] * 5),
        lambda: assign_frame_ids_request(0, [0x40]),
    ):
        with pytest.raises(BadValue):
            wrong()


@each(
    ("answer", "why"),
    [
        ("f2 01", ""),
        ("", ""),
        ("7f b2 12", "it refuses service 0xb2: it does not have that (0x12)"),
        ("7f 22 31", "it refuses service 0x22: code (0x31)"),
        ("7f", "it refuses the request: code (0x00)"),
    ],
)
def test_refusals(answer: str, why: str) -> None:
    assert lin_refusal(bytes.fromhex(answer)) == why


@pytest.fixture
def hub(hub_address: str) -> Iterator[Hub]:
    with connect(hub_address, name="tester") as client:
        yield client


@pytest.fixture
def gauge(hub: Hub) -> LinControl:
    """A configured slave on a board of its own; quick, so that tests are."""
    board = hub.plug("usb-to-can-fd", "HW777777")
    control = hub.open_lin_control(board.id, 2)
    control.initialise(LinMode(master=False, bit_rate=19_200))
    control.respond(LinFrame(0x20, b"\x05"))
    product = LinProduct(0x1234, 0x5678, 1)
    control.configure(LinNodeAttributes(product, 0x11, {0: 0x20}, 7, {32: b"\xaa\xbb"}, p2_ns=1_000_000))
    control.start()
    return control


def said(served: Served, capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> str:
    assert served.run(*words) == status
    captured = capsys.readouterr()
    return (captured.out or captured.err.removeprefix("canwire: ")).rstrip()


def test_a_slave_is_asked_and_configured(
    served: Served, hub: Hub, gauge: LinControl, capsys: pytest.CaptureFixture[str]
) -> None:
    identity = "supplier 1234, function 5678, variant 1"
    assert said(served, capsys, "identify", "lin0", "11") == f"NAD 11: {identity}"
    assert said(served, capsys, "identify", "lin0", "11", "--id", "1") == "NAD 11: serial number 7"
    assert said(served, capsys, "identify", "lin0", "11", "--id", "32") == "NAD 11: identifier 32: AA BB"
    refused = said(served, capsys, "identify", "lin0", "11", "--id", "33", status=1)
    assert refused == "NAD 11: it refuses service 0xb2: it does not have that (0x12)"
    assert said(served, capsys, "assign", "lin0", "11", "--nad", "22") == "NAD 11: is NAD 22 now"
    assert said(served, capsys, "assign", "lin0", "22", "--frames", "0:0E,-") == "NAD 22: done"
    assert said(served, capsys, "save", "lin0", "22") == "NAD 22: saved"
    gauge.power_up()
    assert (gauge.configuration().nad, gauge.configuration().frames) == (0x22, {0: 0x0E})
    raw = said(served, capsys, "request", "lin0", "22", "B2.00.FF7F.FFFF")
    assert raw == "NAD 22: F2 34 12 78 56 01"
    assert said(served, capsys, "request", "lin0", "7E", "3E.00") == "NAD 7E: sent"
    assert served.run("send", "lin0", "0E#R") == 0
    assert texts(capsys.readouterr().out.splitlines()) == ["lin0 0E#05 R"]


def test_nobody_has_that_nad(served: Served, gauge: LinControl, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("identify", "lin0", "33", "--timeout", "0.1")
    assert said(served, capsys, *words, status=2) == "HW000001:2: no response of NAD 0x33 to its request"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("request", "lin0", "11", "B2.0"), "payload 'B2.0': bytes in hex"),
        (("request", "lin0", "100", "B2"), "NAD 100: from 00 to FF"),
        (("request", "lin0", "x", "B2"), "NAD 'x': a number in hex"),
        (("assign", "lin0", "11", "--frames", "10"), "--frames '10': an index and identifiers"),
        (("assign", "lin0", "11", "--frames", "0:zz"), "--frames 'zz': a number in hex"),
        (("slave", "lin0", "--ldf", "x.ldf"), "give a description by --ldf and one of its slaves by --node"),
        (("slave", "lin0", "--node", "x"), "give a description by --ldf and one of its slaves by --node"),
        (("slave", "lin0", "x=20#05"), "frame 'x=20#05': like 20#05, or 0=20#05"),
        (("slave", "lin0", "--nad", "zz"), "--nad 'zz': a number in hex"),
        (("slave", "lin0", "--nad", "7E"), "nad 126: from 0x01 to 0x7D"),
        (("slave", "lin0", "--ldf", str(DOOR), "--node", "door"), "door has no Node_attributes"),
    ],
)
def test_mistakes(
    served: Served, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert served.run(*words) == 2
    assert why in errors(capsys)[0]


def test_a_verb_is_a_slave(served: Served, hub: Hub, start, capsys: pytest.CaptureFixture[str]) -> None:  # type: ignore[no-untyped-def]
    words = ("--nad", "11", "--supplier", "1234", "--function", "5678", "--serial", "FF")
    slave = start("slave", "lin0", "0=20#05", "1=10#R", *words)
    assert slave.told() == "HW000001:2 on lin0: slave at NAD 11; listening"
    hub.plug("usb-to-can-fd", "HW777777")
    assert said(served, capsys, "identify", "lin0", "11", "--id", "1") == "NAD 11: serial number 255"
    assert said(served, capsys, "assign", "lin0", "11", "--frames", "0:0E") == "NAD 11: done"
    assert served.run("send", "lin0", "0E#R") == 0
    assert texts(capsys.readouterr().out.splitlines()) == ["lin0 0E#05 R"]
    while texts([line := slave.line()]) != ["lin0 0E#05 T"]:
        assert line
    assert slave.end(signal.SIGINT)[0] == 130


def test_a_description_is_a_slave(
    served: Served, hub: Hub, start, capsys: pytest.CaptureFixture[str]
) -> None:  # type: ignore[no-untyped-def]
    slave = start("slave", "lin0", "--ldf", str(DOOR), "--node", "left")
    nad = slave.told().partition("NAD ")[2][:2]
    hub.plug("usb-to-can-fd", "HW777777")
    assert said(served, capsys, "identify", "lin0", nad).startswith(f"NAD {nad}: supplier ")
    slave.end(signal.SIGINT)


def test_help_of_each(capsys: pytest.CaptureFixture[str]) -> None:
    for verb in ("slave", "identify", "assign", "save", "request"):
        with pytest.raises(SystemExit):
            main(["lin", verb, "--help"])
        assert f"canwire lin {verb}" in capsys.readouterr().out
