"""The fixtures for programs on shared boards, and what a failing test shows of them."""

from __future__ import annotations

import pytest

from canwire import CanBusFaults, Hub

can = pytest.importorskip("can")
pytest_plugins = ["pytester"]


@pytest.mark.smoke
def test_six_lines_for_a_program_and_an_error_frame(canwire_hub: Hub, canwire_faults: CanBusFaults) -> None:
    with (
        can.Bus("can0", interface="canwire", hub=canwire_hub) as ecu,
        can.Bus("can0", interface="canwire", hub=canwire_hub, error_frames=True) as reader,
    ):
        canwire_faults.inject("crc", frame_id=0x123)
        ecu.send(can.Message(arbitration_id=0x123, is_extended_id=False))
        first, second = reader.recv(1), reader.recv(1)
    assert first is not None
    assert first.is_error_frame
    assert second is not None
    assert (second.arbitration_id, second.is_error_frame) == (0x123, False)


def test_each_test_has_a_hub_of_its_own_in_virtual_time(
    canwire_hub: Hub, canwire_faults: CanBusFaults
) -> None:
    assert (canwire_hub.time, canwire_hub.now_ns(), canwire_faults.list()) == ("virtual", 0, ())


def test_a_failing_test_shows_faults_and_lines(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(
        """
        import can
        def test_it(canwire_hub, canwire_faults):
            bus = can.Bus("can0", interface="canwire", hub=canwire_hub)
            canwire_faults.flip(bit=20, times=2)
            bus.send(can.Message(arbitration_id=0x123, is_extended_id=False))
            canwire_hub.run_for(0.01)
            assert False, "to see the report"
        def test_nothing(canwire_hub):
            assert False
        """
    )
    result = pytester.runpytest("-p", "canwire.pytest_plugin", "-p", "no:cacheprovider")
    result.assert_outcomes(failed=2)
    text = result.stdout.str()
    assert "- canwire: hub -" in text
    assert "can0: flip bit 20 of any frame, 2 times; struck 2, used up" in text
    assert "HW000001:0: ERROR_PASSIVE, TEC 128, REC 0, lost 0" in text
    assert "no fault was set, no line set up" in text
