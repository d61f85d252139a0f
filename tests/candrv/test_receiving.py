"""Which of a handle's messages a confirmation is for, if the hub had no room for the one before it."""

from __future__ import annotations

from types import SimpleNamespace

from canwire import SELF_RECEPTION
from canwire.candrv.device.state import DeviceState
from canwire.candrv.handle.receiving import RECORD, Key, Receiver, Ticket
from canwire.ring import Ring
from tests.cases import each


@each(
    ("confirmed", "done"),
    [(0, [True, False, False]), (1, [True, True, False]), (2, [True, True, True]), (7, [False] * 3)],
)
def test_a_confirmation_is_also_for_the_messages_before(confirmed: int, done: list[bool]) -> None:
    receiver = Receiver(None, look=lambda: DeviceState(500_000), align=0, tells_sent=False, level=0)
    tickets = [Ticket(Key(number, 0, bytes(8)), counts_loaded=False) for number in range(3)]
    receiver.tickets.extend(tickets)
    ring = Ring(16)
    ring.put_bytes(RECORD.pack(0, confirmed, SELF_RECEPTION, bytes(8)))
    receiver.take(SimpleNamespace(ring=ring))  # type: ignore[arg-type]
    assert [ticket.done for ticket in tickets] == done
    assert list(receiver.tickets) == [ticket for ticket in tickets if not ticket.done]
