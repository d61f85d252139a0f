"""A node whose frames are disturbed goes bus-off, and comes back: python examples/bus_off.py"""

from __future__ import annotations

from canwire import ErrorState, Frame, Lab


def main() -> list[tuple[str, int]]:
    """The states of the node, each with its transmit error counter."""
    story: list[tuple[str, int]] = []
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        node, other = bus.node("node"), bus.node("other")
        bus.faults.flip(bit="crc delimiter", frame_id=0x123, times=None, seen_by="sender")
        node.send(Frame(0x123, b"\x01"))
        while not story or node.state is not ErrorState.BUS_OFF:
            lab.run_for(0.0001)
            if not story or story[-1][0] != node.state.name:
                story.append((node.state.name, node.tec))

        bus.faults.clear()  # whatever was wrong has been repaired
        heard_before = len(
            other.receive_many(1000)
        )  # error passive, its flags no longer destroyed the frames
        off_ns = lab.now_ns
        node.restart()
        node.send(Frame(0x123, b"\x02"))
        back = other.expect(0x123, within=1.0)
        story.append((node.state.name, node.tec))
        back_ms = (back.timestamp_ns - off_ns) / 1e6
    for state, tec in story:
        print(f"{state:15} TEC {tec}")
    print(f"the other node has accepted {heard_before} copies of the frame meanwhile")
    print(f"back {back_ms:.3f} ms after the restart: 128 times 11 recessive bits, and its first frame")
    return story


if __name__ == "__main__":
    main()
