"""CANDRV over the network: a message that the hub refuses as too old ends its wait, and a lost hub is told."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing

import pytest

from canwire import candrv
from canwire.candrv import CandrvError
from canwire.candrv.constants import Win32Error
from canwire.candrv.handle import elsewhere as waiting
from canwire.candrv.registry.registry import RegistryStore
from canwire.hub.links.local import LocalLink
from canwire.hub.links.network.bridge import Bridge
from canwire.hub.links.network.offered import Offered
from tests.candrv.conftest import CONFIG
from tests.hub.links.network.places import Place, elsewhere
from tests.hubs import LONG_S, embedded, free_port, until

pytestmark = [pytest.mark.conforms("N-59"), pytest.mark.realtime]


@pytest.fixture
def place() -> Iterator[Place]:
    port = free_port()
    at = Offered(realm="tests", name="bench", listen=(f"tcp/127.0.0.1:{port}",), age_s=2.0)
    with (
        embedded(CONFIG) as engine,
        closing(Bridge(lambda name: LocalLink(engine, name), at, lambda: None)) as bridge,
    ):
        yield Place(engine, port, bridge)


def test_a_message_that_was_under_way_for_too_long_ends_its_wait(
    place: Place, registry: RegistryStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    registry.set("CID1", "TxMode", 6)
    monkeypatch.setattr(waiting, "LOOK_S", 0.02)
    raised: list[int] = []
    with elsewhere(place.address) as hub, candrv.open(hub=hub) as handle:
        guest = next(iter(place.bridge._guests.values()))
        monkeypatch.setattr(guest.late, "refusal", lambda asked, now_ns: None)  # frames alone are late
        monkeypatch.setattr(guest.late.age, "over_s", lambda stamp, now_ns: 100.0 if stamp else 0.0)

        def write() -> None:
            with pytest.raises(CandrvError, match="under way to the hub for too long") as caught:
                handle.write("1 0 0\n")
            raised.append(caught.value.code)

        thread = threading.Thread(target=write)
        thread.start()
        thread.join(LONG_S)
    assert raised == [Win32Error.ERROR_OPERATION_ABORTED]


def test_waiting_says_that_the_hub_is_lost(place: Place) -> None:
    with elsewhere(place.address) as hub, candrv.open(hub=hub) as handle:
        assert handle.waiting == 0
        place.bridge.close()

        def lost() -> bool:
            try:
                return handle.waiting < 0
            except CandrvError as error:
                return error.code == Win32Error.ERROR_DEV_NOT_EXIST

        until(lost)
