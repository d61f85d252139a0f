"""The small UDS ECU, asked by udsoncan's own client in the lab's time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from canwire import Frame, Lab

isotp = pytest.importorskip("isotp")
udsoncan = pytest.importorskip("udsoncan")

from udsoncan.client import Client  # noqa: E402
from udsoncan.exceptions import NegativeResponseException, TimeoutException  # noqa: E402

from canwire.ecus import LabIsoTp, UdsConnection, UdsEcu  # noqa: E402

pytestmark = [pytest.mark.conforms("PP-02"), pytest.mark.filterwarnings("default::DeprecationWarning")]
VIN = b"CANWIRE0123456789"


class Raw(udsoncan.DidCodec):  # type: ignore[misc]
    """Bytes as they are."""

    def encode(self, value: bytes) -> bytes:
        return value

    def decode(self, payload: bytes) -> bytes:
        return payload

    def __len__(self) -> int:
        raise self.ReadAllRemainingData


CONFIG = {
    **udsoncan.configs.default_client_config,
    "data_identifiers": {"default": Raw},
    "security_algo": lambda level, seed, params: bytes(each ^ 0xFF for each in seed),
}


@pytest.fixture
def lab() -> Iterator[Lab]:
    with Lab() as made:
        yield made


@pytest.fixture
def ecu(lab: Lab) -> UdsEcu:
    made = UdsEcu(identifiers={0xF190: VIN, 0x0101: b"\x05"}, writable=(0x0101,), memory=4096)
    lab.can_bus("can0", bit_rate=500_000).node("ecu", made)
    return made


@pytest.fixture
def client(lab: Lab, ecu: UdsEcu) -> Iterator[Client]:
    with Client(UdsConnection(lab.buses["can0"].node("tester")), config=CONFIG) as made:
        yield made


def refused(call: Any, *words: Any) -> str:
    with pytest.raises(NegativeResponseException) as error:
        call(*words)
    return str(error.value.response.code_name)


@pytest.mark.smoke
def test_identifiers(client: Client) -> None:
    """The first answer takes several frames, with flow control between."""
    assert client.read_data_by_identifier(0xF190).service_data.values[0xF190] == VIN
    assert refused(client.read_data_by_identifier, 0x1234) == "RequestOutOfRange"


def test_writing_needs_session_and_key(client: Client, ecu: UdsEcu) -> None:
    write = client.write_data_by_identifier
    assert refused(write, 0xF190, b"X") == "RequestOutOfRange"
    assert refused(write, 0x0101, b"\7") == "ServiceNotSupportedInActiveSession"
    client.change_session(3)
    assert refused(write, 0x0101, b"\7") == "SecurityAccessDenied"
    client.unlock_security_access(1)
    write(0x0101, b"\7")
    assert client.read_data_by_identifier(0x0101).service_data.values[0x0101] == b"\7"
    assert ecu.identifiers[0x0101] == b"\7"
    client.ecu_reset(1)
    assert (ecu.resets, ecu.session, ecu.unlocked) == (1, 1, False)


def test_wrong_keys_lock_it_for_ten_seconds(lab: Lab, client: Client) -> None:
    assert refused(client.request_seed, 1) == "ServiceNotSupportedInActiveSession"
    client.change_session(3)
    assert refused(client.send_key, 2, b"no seed was asked for") == "RequestSequenceError"
    codes = []
    for _ in range(3):
        client.request_seed(1)
        codes.append(refused(client.send_key, 2, b"wrong"))
    assert codes == ["InvalidKey", "InvalidKey", "ExceedNumberOfAttempts"]
    assert refused(client.request_seed, 1) == "RequiredTimeDelayNotExpired"
    for _ in range(4):
        lab.run_for(2.5)
        client.tester_present()
    client.unlock_security_access(1)
    assert client.request_seed(1).service_data.seed == bytes(4)


@pytest.mark.parametrize("size", [1, 255, 256, 257, 4096])
def test_a_flash_download(client: Client, ecu: UdsEcu, size: int) -> None:
    image = bytes(number * 7 & 0xFF for number in range(size))
    place = udsoncan.MemoryLocation(0x0800_0000, size, 32, 32)
    assert refused(client.request_download, place) == "ServiceNotSupportedInActiveSession"
    client.change_session(2)
    assert refused(client.request_download, place) == "SecurityAccessDenied"
    client.unlock_security_access(1)
    assert refused(client.transfer_data, 1, b"\0") == "RequestSequenceError"
    longest = client.request_download(place).service_data.max_length - 2
    for number, start in enumerate(range(0, size, longest), 1):
        client.transfer_data(number & 0xFF, image[start : start + longest])
    client.request_transfer_exit()
    assert bytes(ecu.memory[:size]) == image
    assert refused(client.request_transfer_exit) == "RequestSequenceError"


def test_downloads_that_go_wrong(client: Client, ecu: UdsEcu) -> None:
    client.change_session(2)
    client.unlock_security_access(1)
    beyond = udsoncan.MemoryLocation(0x0800_0000 + 4095, 2, 32, 32)
    assert refused(client.request_download, beyond) == "RequestOutOfRange"
    client.request_download(udsoncan.MemoryLocation(0x0800_0000, 4, 32, 32))
    assert refused(client.transfer_data, 2, b"\0\1") == "WrongBlockSequenceCounter"
    client.transfer_data(1, b"\0\1")
    assert refused(client.request_transfer_exit) == "RequestSequenceError"
    assert refused(client.transfer_data, 2, b"\2\3\4") == "TransferDataSuspended"
    assert bytes(ecu.memory[:5]) == b"\0\1\xff\xff\xff"


def test_silence_ends_the_session(lab: Lab, client: Client, ecu: UdsEcu) -> None:
    client.change_session(3)
    lab.run_for(4)
    with client.suppress_positive_response:
        client.tester_present()
    lab.run_for(4)
    assert ecu.session == 3
    lab.run_for(1.1)
    assert ecu.session == 1


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("85 01", "7f 85 11"),
        ("10 05", "7f 10 12"),
        ("11 09", "7f 11 12"),
        ("3e 01", "7f 3e 12"),
        ("22 f1", "7f 22 13"),
        ("2e 01 01", "7f 2e 13"),
        ("ff", "7f ff 11"),
    ],
)
def test_requests_that_mean_nothing(ecu: UdsEcu, request_: str, answer: str) -> None:
    told = ecu.answer(bytes.fromhex(request_))
    assert told is not None
    assert told.hex(" ") == answer


def test_no_answer_ends_in_the_lab_s_time(lab: Lab) -> None:
    """P2 is over in the lab after a second."""
    bus = lab.can_bus("can0", bit_rate=500_000)
    bus.node("somebody")
    with Client(UdsConnection(bus.node("tester")), config=CONFIG) as client, pytest.raises(TimeoutException):
        client.tester_present()
    assert lab.now_ns == pytest.approx(1e9, rel=0.01)


@pytest.mark.conforms("PP-01")
def test_a_flow_control_that_never_comes_ends_in_the_lab_s_time(lab: Lab) -> None:
    bus = lab.can_bus("can0", bit_rate=500_000)
    silent = bus.node("silent")
    sender = LabIsoTp(
        bus.node("sender"),
        isotp.Address(isotp.AddressingMode.Normal_11bits, txid=0x7E0, rxid=0x7E8),
        params={"rx_flowcontrol_timeout": 250},
    )
    sender.send(bytes(100))
    lab.run_until_idle()
    assert [type(error).__name__ for error in sender.errors] == ["FlowControlTimeoutError"]
    assert not sender.sending
    assert 250_000_000 < lab.now_ns < 260_000_000
    assert silent.receive_many(9) == [Frame(0x7E0, bytes.fromhex("1064 000000000000"))]


@pytest.mark.conforms("PP-01")
def test_separation_time_is_the_bus_s_time(lab: Lab) -> None:
    """A receiver that wants 10 ms between frames gets them, in no time."""
    bus = lab.can_bus("can0", bit_rate=500_000)
    normal = isotp.AddressingMode.Normal_11bits
    sender = LabIsoTp(bus.node("sender"), isotp.Address(normal, txid=0x7E0, rxid=0x7E8))
    receiver = LabIsoTp(
        bus.node("receiver"), isotp.Address(normal, txid=0x7E8, rxid=0x7E0), params={"stmin": 10}
    )
    sender.send(bytes(range(100)))
    assert receiver.receive(1.0) == bytes(range(100))
    assert 140_000_000 <= lab.now_ns <= 160_000_000  # fourteen consecutive frames
