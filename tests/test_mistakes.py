"""Natural first mistakes: each is answered with what is wrong, where, and what to write instead.

A row is the mistake and the exact text of its error. Names of other libraries, wrong types, misspelt methods,
values out of range. When a text gets better, its row changes with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import canwire

ROOT = Path(__file__).parent.parent


class Quiet(canwire.NodeScript):
    """A script that does nothing."""


def misspelt() -> type:
    class Engine(canwire.NodeScript):
        def on_mesage(self, frame: canwire.Frame) -> None:
            """Would never be called."""

    return Engine


def never_called() -> type:
    class Engine(canwire.NodeScript):
        def on_recieve(self, frame: canwire.Frame) -> None:
            """Would never be called."""

    return Engine


@pytest.fixture(scope="module")
def names() -> Iterator[dict[str, Any]]:
    """What the rows speak of."""
    can = pytest.importorskip("can")
    pytest.importorskip("cantools")
    with canwire.Lab() as lab, canwire.connect(time="virtual") as hub:
        bus = lab.can_bus("can0", bit_rate=500_000)
        lin = lab.lin_bus("lin0")
        placed = Quiet()
        bus.node("tester", placed)
        board = hub.board("usb-to-can-fd").id
        can_bus = can.Bus(interface="canwire", channel=lab.can_bus("python-can"))
        yield {
            **{name: getattr(canwire, name) for name in canwire.__all__},
            "canwire": canwire,
            "can": can,
            "lab": lab,
            "bus": bus,
            "node": bus.node("engine"),
            "lin": lin,
            "master": lin.master("m"),
            "board": board,
            "hub_bus": hub.bus("can0"),
            "placed": placed,
            "frame": canwire.Frame(0x123, b"\x11"),
            "db": canwire.load_database(ROOT / "examples" / "engine.dbc"),
            "hub": hub,
            "channel": hub.open_channel(board, 0),
            "control": hub.open_control(board, 0),
            "can_bus": can_bus,
            "Quiet": Quiet,
            "misspelt": misspelt,
            "never_called": never_called,
        }
        can_bus.shutdown()


MISTAKES: list[tuple[str, str]] = [
    (
        "Frame(arbitration_id=0x123)",
        "TypeError: Frame() has no argument 'arbitration_id': what python-can calls arbitration_id is "
        "id here",
    ),
    (
        'Frame("0x123")',
        "BadFrame: identifier '0x123' is no whole number",
    ),
    (
        "Frame(0x800)",
        "BadFrame: identifier 0x800 needs more than 11 bits (0..0x7FF); add extended=True for a 29-bit one",
    ),
    (
        'Frame(0x123, "112233")',
        "BadFrame: data '112233' is not bytes",
    ),
    (
        'Frame(0x123, b"123456789")',
        "BadFrame: 9 bytes: a classic frame carries at most 8; add fd=True for up to 64",
    ),
    (
        'Frame(0x123, b"1", bit_rate_switch=True)',
        "BadFrame: bit_rate_switch and error_state_indicator exist only in FD frames; add fd=True",
    ),
    (
        'Frame(0x123, b"1", remote=True)',
        "BadFrame: a remote frame carries no data (1 bytes given); give the length it asks for as dlc",
    ),
    (
        "frame.arbitration_id",
        "AttributeError: Frame has no attribute 'arbitration_id': the identifier is frame.id",
    ),
    (
        "frame.is_extended_id",
        "AttributeError: Frame has no attribute 'is_extended_id': that is frame.extended",
    ),
    (
        "frame.is_fd",
        "AttributeError: Frame has no attribute 'is_fd': that is frame.fd",
    ),
    (
        "frame.timestamp",
        "AttributeError: Frame has no attribute 'timestamp': the time is frame.timestamp_ns, in nanoseconds",
    ),
    (
        "frame.length",
        "AttributeError: Frame has no attribute 'length': the length is len(frame.data), the code on "
        "the wire frame.dlc",
    ),
    (
        "frame.payload",
        "AttributeError: Frame has no attribute 'payload': the bytes are frame.data",
    ),
    (
        "Lab(realtime=True)",
        "TypeError: Lab() has no argument 'realtime'; did you mean 'time'?",
    ),
    (
        "Lab(pace=1)",
        "TypeError: Lab() has no argument 'pace'; it has time, seed",
    ),
    (
        'lab.bus("can0")',
        "AttributeError: Lab has no attribute 'bus': a bus is made by lab.can_bus(\"can0\", "
        'bit_rate=500_000) or lab.lin_bus("lin0"); lab.buses has them',
    ),
    (
        'lab.add_bus("can0")',
        "AttributeError: Lab has no attribute 'add_bus': a bus is made by lab.can_bus(\"can0\", "
        'bit_rate=500_000) or lab.lin_bus("lin0"); lab.buses has them',
    ),
    (
        'lab.node("engine")',
        "AttributeError: Lab has no attribute 'node': nodes are on a bus: "
        'lab.can_bus("can0").node("engine")',
    ),
    (
        "lab.step()",
        "AttributeError: Lab has no attribute 'step': time passes by lab.run_for(seconds), "
        "lab.run_until(time_ns) or lab.run_until_idle()",
    ),
    (
        "lab.start()",
        "AttributeError: Lab has no attribute 'start': a lab needs no start: time passes by "
        "lab.run_for(seconds), lab.run_until(time_ns) or lab.run_until_idle()",
    ),
    (
        "lab.stop()",
        "AttributeError: Lab has no attribute 'stop': a lab ends with its `with` block, or by lab.close()",
    ),
    (
        "lab.wait(1)",
        "AttributeError: Lab has no attribute 'wait': time passes by lab.run_for(seconds), "
        "lab.run_until(time_ns) or lab.run_until_idle()",
    ),
    (
        "lab.run(1)",
        "TypeError: main 1: must be a coroutine; lab.run_for(seconds) lets time pass",
    ),
    (
        'lab.run_for("1")',
        "TypeError: seconds '1': must be int or float, not str",
    ),
    (
        "lab.run_for(-1)",
        "BadValue: seconds -1: a finite time, not negative, of at most 146 years",
    ),
    (
        'lab.can_bus("can1", bit_rate="500k")',
        "BadTiming: bit_rate '500k': a whole number above 0, such as 500_000 for 500 kbit/s",
    ),
    (
        'lab.can_bus("can1", bitrate=500_000)',
        "TypeError: can_bus() has no argument 'bitrate': what python-can calls bitrate is bit_rate here",
    ),
    (
        'lab.can_bus("can1", bit_rate=500_000, data_bit_rate="2M")',
        "BadTiming: data_bit_rate '2M': a whole number above 0, such as 500_000 for 500 kbit/s",
    ),
    (
        'lab.can_bus("can1", fd=True)',
        "TypeError: can_bus() has no argument 'fd'; it has name, bit_rate, data_bit_rate, timing, "
        "data_timing, iso_fd, length_m, node_delay_ns",
    ),
    (
        "lab.can_bus(500_000)",
        "TypeError: name 500000: must be str, not int",
    ),
    (
        'lab.can_bus("can0")',
        "BadValue: there is a bus 'can0' already",
    ),
    (
        'lab.can_bus("can1", length_m="5")',
        "TypeError: length_m '5': must be int or float, not str",
    ),
    (
        'lab.lin_bus("lin1", bitrate=19_200)',
        "TypeError: lin_bus() has no argument 'bitrate': what python-can calls bitrate is bit_rate here",
    ),
    (
        'lab.lin_bus("lin1", bit_rate=250_000)',
        "BadValue: bit_rate 250000: LIN runs at 1000 to 20000 bit/s",
    ),
    (
        'lin.node("slave")',
        "AttributeError: LabLinBus has no attribute 'node': nodes of a LIN bus are made by "
        "bus.master(name) and bus.slave(name)",
    ),
    (
        "bus.send(frame)",
        "AttributeError: LabBus has no attribute 'send': a bus neither sends nor receives, its nodes "
        'do: node = bus.node("tester"), then node.send(frame)',
    ),
    (
        "bus.recv()",
        "AttributeError: LabBus has no attribute 'recv': a bus neither sends nor receives, its nodes "
        'do: node = bus.node("tester"), then node.receive(timeout)',
    ),
    (
        "bus.receive()",
        "AttributeError: LabBus has no attribute 'receive': a bus neither sends nor receives, its nodes "
        'do: node = bus.node("tester"), then node.receive(timeout)',
    ),
    (
        'bus.add_node("tester")',
        "AttributeError: LabBus has no attribute 'add_node': bus.node(\"engine\") makes a node",
    ),
    (
        "bus.bitrate",
        "AttributeError: LabBus has no attribute 'bitrate': its bit rate is bus.timing.bit_rate",
    ),
    (
        "bus.shutdown()",
        "AttributeError: LabBus has no attribute 'shutdown': a bus ends with its lab: lab.close()",
    ),
    (
        "bus.flip(bit=20)",
        "AttributeError: LabBus has no attribute 'flip': what goes wrong on a bus is bus.faults: "
        "bus.faults.flip(bit=20)",
    ),
    (
        'bus.master("m")',
        "AttributeError: LabBus has no attribute 'master': a CAN bus has no master: bus.node(name); "
        "LIN's is lab.lin_bus().master(name)",
    ),
    (
        'bus.node("engine")',
        "BadValue: can0: there is a node 'engine' already",
    ),
    (
        'bus.node("new", bitrate=500_000)',
        "TypeError: node() has no argument 'bitrate': what python-can calls bitrate is bit_rate here",
    ),
    (
        'bus.node("new", bit_rate="500k")',
        "BadTiming: bit_rate '500k': a whole number above 0, such as 500_000 for 500 kbit/s",
    ),
    (
        'bus.node("new", filters=0x123)',
        "BadFilter: filters 291: give a list of (code, mask), such as [(0x120, 0x7F0)]",
    ),
    (
        'bus.node("new", filters=[{"can_id": 0x123, "can_mask": 0x7FF}])',
        "BadFilter: filter {'can_id': 291, 'can_mask': 2047}: give (code, mask), or (code, mask, True) "
        "for 29-bit frames",
    ),
    (
        'bus.node("new", controller="mcp2515")',
        "BadValue: controller 'mcp2515': 'fd' or 'sja1000'",
    ),
    (
        'bus.node("new", oscillator_ppm="50")',
        "TypeError: oscillator_ppm '50': must be int or float, not str",
    ),
    (
        'bus.node("new", Quiet)',
        "TypeError: script <class 'tests.test_mistakes.Quiet'>: must be an object such as MyScript(), "
        "of a class made from NodeScript",
    ),
    (
        'bus.node("new", placed)',
        "BadValue: script Quiet: node can0/tester has this object; give each node a separate one, Quiet()",
    ),
    (
        "Quiet().send(frame)",
        "AttributeError: Quiet is on no bus yet: bus.node(name, script) puts it on one, and calls its "
        "on_start",
    ),
    (
        "misspelt()",
        "TypeError: Engine.on_mesage: a NodeScript never calls it; received frames come to "
        "on_message(frame), and its other methods are on_start, on_event, on_timer",
    ),
    (
        "never_called()",
        "TypeError: Engine.on_recieve: a NodeScript never calls it; received frames come to "
        "on_message(frame), and its other methods are on_start, on_event, on_timer",
    ),
    (
        "node.recv()",
        "AttributeError: LabNode has no attribute 'recv': a node receives by node.receive(timeout), and "
        "node.expect(0x123, within=1.0) waits for one frame",
    ),
    (
        "node.recieve()",
        "AttributeError: LabNode has no attribute 'recieve': a node receives by node.receive(timeout), "
        "and node.expect(0x123, within=1.0) waits for one frame",
    ),
    (
        "node.read()",
        "AttributeError: LabNode has no attribute 'read': a node receives by node.receive(timeout), and "
        "node.expect(0x123, within=1.0) waits for one frame",
    ),
    (
        "node.write(frame)",
        "AttributeError: LabNode has no attribute 'write': a node sends by "
        'node.send(canwire.Frame(0x123, b"\\x11"))',
    ),
    (
        "node.transmit(frame)",
        "AttributeError: LabNode has no attribute 'transmit': a node sends by "
        'node.send(canwire.Frame(0x123, b"\\x11"))',
    ),
    (
        "node.send(0x123)",
        "TypeError: frame 0x123: must be Frame, not int; write Frame(0x123, data)",
    ),
    (
        'node.send("123#1122")',
        "TypeError: frame '123#1122': must be Frame, not str; parse_frame(text) makes one of 123#1122",
    ),
    (
        'node.send(LinFrame(0x10, b"1"))',
        'TypeError: frame LinFrame(0x10, bytes.fromhex("31")): must be Frame, not LinFrame',
    ),
    (
        "node.send_periodic(frame, 0.1)",
        "AttributeError: LabNode has no attribute 'send_periodic': a script sends in cycles: "
        "`self.every(0.1, self.report)` in on_start of a canwire.NodeScript",
    ),
    (
        "node.set_filters([])",
        "AttributeError: LabNode has no attribute 'set_filters': filters are given when the node is "
        "made: bus.node(name, filters=[(0x120, 0x7F0)])",
    ),
    (
        "node.on_message",
        "AttributeError: LabNode has no attribute 'on_message': a script has on_message(frame): "
        "bus.node(name, MyScript()) with a class made from canwire.NodeScript",
    ),
    (
        'node.send_message("EngineData")',
        "AttributeError: LabNode has no attribute 'send_message': messages have names by a database: "
        'db.on(node).send_message("EngineData", EngineSpeed=1500)',
    ),
    (
        'node.receive("1")',
        "TypeError: timeout '1': must be int or float, not str",
    ),
    (
        "node.receive(-1)",
        "BadValue: timeout -1: a finite time, not negative, of at most 146 years",
    ),
    (
        'node.expect("EngineData", within=1)',
        "TypeError: id 'EngineData': must be int, not str; a message has a name by a database: "
        "db.on(node).expect_message('EngineData', within=...)",
    ),
    (
        "node.expect(0x123, timeout=1)",
        "TypeError: expect() has no argument 'timeout'; it has id, within, extended, data; for example "
        "node.expect(0x123, within=1.0)",
    ),
    (
        "node.expect(frame, within=1)",
        'TypeError: id Frame(0x123, bytes.fromhex("11")): must be int, not Frame',
    ),
    (
        "bus.faults.flip(bit=500)",
        "BadValue: bit 500: the longest frame of this bus ends with bit 156, stuff bits included",
    ),
    (
        "bus.faults.flip(bit=-1)",
        "BadValue: bit -1: bits count from 0 (SOF), or have a name",
    ),
    (
        "bus.faults.flip_bit(20)",
        "AttributeError: LabFaults has no attribute 'flip_bit': a bit is inverted by "
        'faults.flip(bit=20), an error provoked by faults.inject("crc")',
    ),
    (
        "bus.faults.drop(0x123)",
        "AttributeError: LabFaults has no attribute 'drop': a frame is destroyed by faults.flip(bit=20, "
        "frame_id=0x123), and then repeated, as on copper",
    ),
    (
        "bus.faults.noise(2)",
        "BadValue: bit_error_rate 2: from 0 up to, not including, 1",
    ),
    (
        'bus.faults.noise("2")',
        "TypeError: bit_error_rate '2': must be int or float, not str",
    ),
    (
        "bus.faults.unplug(node)",
        "AttributeError: LabFaults has no attribute 'unplug': a node's plug is pulled by "
        "faults.disconnect(node)",
    ),
    (
        "db.encode(256, {})",
        "TypeError: message 256: must be its name, not int; 0x100 is 'EngineData'",
    ),
    (
        'db.encode("EngineDate", {})',
        "BadValue: ROOT/examples/engine.dbc: no message 'EngineDate'; did you mean EngineData?",
    ),
    (
        'db.encode("EngineData", {"Sped": 1})',
        "BadSignals: EngineData.Sped: no such signal; there are EngineSpeed, Temperature, Ready, Alive, "
        "Check",
    ),
    (
        'db.encode("EngineData", {"EngineSpeed": "quick"})',
        "BadSignals: EngineData.EngineSpeed: 'quick' is no number; 0 to 16000 rpm is possible",
    ),
    (
        'db.encode("EngineData", [1])',
        "TypeError: signals [1]: must be Mapping, not list",
    ),
    (
        'db.decode(b"12345678")',
        "TypeError: frame b'12345678': must be Frame or LinFrame, not bytes",
    ),
    (
        'db.encode_message("EngineData", {})',
        "AttributeError: Database has no attribute 'encode_message': db.encode(\"EngineData\", "
        '{"EngineSpeed": 1500}) makes a frame',
    ),
    (
        'db.decode_message(256, b"12345678")',
        "AttributeError: Database has no attribute 'decode_message': db.decode(frame) takes a canwire.Frame",
    ),
    (
        'db.get_message_by_name("EngineData")',
        "AttributeError: Database has no attribute 'get_message_by_name': db.message(\"EngineData\") "
        "gives a message by its name",
    ),
    (
        'db.add_dbc_file("more.dbc")',
        "AttributeError: Database has no attribute 'add_dbc_file': one Database is one file: "
        "canwire.load_database(path)",
    ),
    (
        "load_database(5)",
        "TypeError: path 5: must be str or PathLike, not int",
    ),
    (
        'load_database("none.txt")',
        "BadDescription: none.txt: no network description by its ending; there are .dbc, .arxml, .kcd, "
        ".sym, .ldf",
    ),
    (
        "canwire.Bus",
        "AttributeError: module 'canwire' has no attribute 'Bus': python-can's bus is "
        'can.Bus(interface="canwire", channel="can0"); without python-can, lab = canwire.Lab() and bus '
        '= lab.can_bus("can0", bit_rate=500_000) make a bus',
    ),
    (
        "canwire.Message",
        "AttributeError: module 'canwire' has no attribute 'Message': a frame is canwire.Frame(0x123, "
        'b"\\x11\\x22"); can.Message is python-can\'s, for can.Bus(interface="canwire")',
    ),
    (
        "canwire.Node",
        "AttributeError: module 'canwire' has no attribute 'Node': a node is made by its bus: "
        'canwire.Lab().can_bus("can0").node("engine")',
    ),
    (
        "canwire.CanFrame",
        "AttributeError: module 'canwire' has no attribute 'CanFrame': a frame is canwire.Frame(0x123, "
        'b"\\x11\\x22")',
    ),
    (
        "canwire.Notifier",
        "AttributeError: module 'canwire' has no attribute 'Notifier': Notifier is python-can's, and "
        'works with can.Bus(interface="canwire", channel="can0")',
    ),
    (
        "canwire.Logger",
        "AttributeError: module 'canwire' has no attribute 'Logger': canwire.record(line, path) writes "
        "what a line hears",
    ),
    (
        "canwire.BLFReader",
        "AttributeError: module 'canwire' has no attribute 'BLFReader': canwire.open_log(\"drive.blf\") "
        'reads logs of every format, canwire.create_log("drive.blf") writes them',
    ),
    (
        "canwire.load_file",
        "AttributeError: module 'canwire' has no attribute 'load_file': a description of a network is "
        "read by canwire.load_database(path)",
    ),
    (
        "canwire.isotp",
        "AttributeError: module 'canwire' has no attribute 'isotp': docs/how-to/isotp.md sends messages "
        "longer than a frame; the command is `canwire isotp`",
    ),
    (
        "canwire.CanError",
        "AttributeError: module 'canwire' has no attribute 'CanError': every error is a "
        "canwire.CanwireError; can.CanError is python-can's",
    ),
    (
        "canwire.simulate",
        "AttributeError: module 'canwire' has no attribute 'simulate': db.simulated(\"Engine\") plays a "
        "node of a database; the command is `canwire simulate`",
    ),
    (
        "canwire.LinBus",
        "AttributeError: module 'canwire' has no attribute 'LinBus': a LIN bus is made by "
        'canwire.Lab().lin_bus("lin0")',
    ),
    (
        "BitTiming.from_sample_point(500_000)",
        "AttributeError: BitTiming has no attribute 'from_sample_point': "
        "BitTiming.for_bit_rate(500_000, sample_point=0.8, clock_hz=80_000_000) calculates one",
    ),
    (
        "Acceptance(0x123, 0x7FF)",
        "BadFilter: pairs 291: a tuple of (code, mask) over 64-bit keys; of identifiers "
        "Acceptance.from_filters([(0x120, 0x7F0)]) makes one",
    ),
    (
        "Acceptance.from_filters(0x123)",
        "BadFilter: filters 291: give a list of (code, mask), such as [(0x120, 0x7F0)]",
    ),
    (
        'LinFrame(64, b"1")',
        "BadFrame: LIN identifier 0x40: a whole number from 0 to 0x3F",
    ),
    (
        'parse_frame("123")',
        "BadText: '123' has no #: a frame looks like 123#1122, 12345678#1122, 123#R4 or 123##1AABB",
    ),
    (
        'parse_frame("800#11")',
        "BadText: '800#11': identifier 800 needs more than 11 bits (000 to 7FF); write 8 hex digits for "
        "a 29-bit one: 00000800",
    ),
    (
        'parse_frame("xyz#11")',
        "BadText: 'xyz#11': identifier 'xyz' must have 3 hex digits, or 8 for a 29-bit one",
    ),
    (
        "parse_frame(5)",
        "TypeError: text 5: must be str, not int",
    ),
    (
        "open_log(5)",
        "TypeError: path 5: must be str or PathLike, not int",
    ),
    (
        'create_log("drive.foo")',
        "BadValue: drive.foo: no log format has '.foo'; did you mean .mf4 or .log?",
    ),
    (
        "connect(5)",
        "TypeError: address 5: must be str, not int",
    ),
    (
        'connect("can0")',
        "BadValue: address 'can0': that looks like a line, and this is where its hub listens; leave it "
        "out, and find the line by canwire.find_lines(hub, 'can0')",
    ),
    (
        'connect("tcp://127.0.0.1:2000")',
        "BadValue: address 'tcp://127.0.0.1:2000': a socket's path, or zenoh://REALM/HOST for a hub on "
        "another machine",
    ),
    (
        'hub.line("can0")',
        "AttributeError: Hub has no attribute 'line': canwire.find_lines(hub, \"can0\") finds lines, "
        "hub.open_channel(place.board.id, place.line) opens one",
    ),
    (
        "hub.lines()",
        "AttributeError: Hub has no attribute 'lines': canwire.find_lines(hub, \"can0\") finds lines, "
        "hub.open_channel(place.board.id, place.line) opens one",
    ),
    (
        'hub.open("can0")',
        "AttributeError: Hub has no attribute 'open': canwire.find_lines(hub, \"can0\") finds lines, "
        "hub.open_channel(place.board.id, place.line) opens one",
    ),
    (
        "hub.send(frame)",
        "AttributeError: Hub has no attribute 'send': frames go through a channel: "
        'canwire.find_lines(hub, "can0") finds lines, hub.open_channel(place.board.id, place.line) '
        "opens one",
    ),
    (
        "hub.buses()",
        "AttributeError: Hub has no attribute 'buses': canwire.every_line(hub) lists lines with their buses",
    ),
    (
        'hub.open_channel("can0", 0)',
        "TypeError: board 'can0': must be int, not str; place = canwire.find_lines(hub, name)[0] has "
        "place.board.id and place.line",
    ),
    (
        'hub.open_channel(1, "can0")',
        "TypeError: line 'can0': must be int, not str; place = canwire.find_lines(hub, name)[0] has "
        "place.board.id and place.line",
    ),
    (
        'hub.open_control("can0", 0)',
        "TypeError: board 'can0': must be int, not str; place = canwire.find_lines(hub, name)[0] has "
        "place.board.id and place.line",
    ),
    (
        'hub.board("nope")',
        "NoSuchBoard: no board 'nope'; plugged in: HW000001 (usb-to-can-fd), HW000002 (usb-to-can), "
        "HW000003 (inducan104), HW000004 (picocom1)",
    ),
    (
        "find_lines(hub, 5)",
        "TypeError: name 5: must be str, not int",
    ),
    (
        'find_lines(hub, "canx")',
        "NoSuchBoard: no line or bus 'canx'; there are HW000001:0 (on can0), HW000001:1 (on can0), "
        "HW000001:2 (on lin0), HW000002:0 (on can0), HW000002:1 (on can0), HW000003:0 (on can0), "
        "HW000004:0 (on can0); did you mean can0?",
    ),
    (
        'start_line(hub, "can0", None)',
        "TypeError: place 'can0': must be LinePlace, one of find_lines(hub, name)",
    ),
    (
        "channel.recv()",
        "AttributeError: HubChannel has no attribute 'recv': a channel receives by "
        "channel.receive(timeout), after set_up(...) and activate()",
    ),
    (
        "channel.write(frame)",
        "AttributeError: HubChannel has no attribute 'write': a channel sends by channel.send(frame)",
    ),
    (
        "channel.start()",
        "AttributeError: HubChannel has no attribute 'start': a channel begins by channel.activate(), "
        "its line by hub.open_control(board, line).start()",
    ),
    (
        "channel.set_up(5)",
        "TypeError: mode 5: must be ChannelMode, not int",
    ),
    (
        "channel.activate()",
        "NotInitialised: HW000001:0: set the channel up before activating it",
    ),
    (
        "control.init(500_000)",
        "AttributeError: Control has no attribute 'init': a line is set up by "
        "control.initialise(canwire.LineMode(timing)), then control.start()",
    ),
    (
        "control.initialise(500_000)",
        "TypeError: mode 500000: must be LineMode, not int",
    ),
    (
        "control.start()",
        "NotInitialised: HW000001:0: initialise the line before it is started",
    ),
    (
        'can.Bus(interface="canwire", channel="can0", bitrate="500k")',
        "CanInitializationError: bitrate='500k': a whole number of bit/s, such as 500_000 for 500 kbit/s",
    ),
    (
        'can.Bus(interface="canwire", channel="can0", data_bitrate=2_000_000)',
        "CanInitializationError: data_bitrate=2000000: only CAN FD has a data phase; add fd=True, or "
        "leave it out",
    ),
    (
        'can.Bus(interface="canwire", channel="can0", bit_rate=500_000)',
        "CanInitializationError: can.Bus(interface='canwire'): bit_rate=500000 is no argument; did you "
        "mean bitrate or data_bitrate or auto_bitrate?",
    ),
    (
        'can.Bus(interface="canwire", channel="vcan0")',
        "CanInitializationError: no CAN line or bus 'vcan0'; there are HW000001:0 (on can0), HW000001:1 "
        "(on can0), HW000002:0 (on can0), HW000002:1 (on can0), HW000003:0 (on can0), HW000004:0 (on "
        "can0); did you mean can0?",
    ),
    (
        'can.Bus(interface="canwire", channel="can0", hub=5)',
        "CanInitializationError: hub=5: the address of a hub's socket, a canwire.Hub or a canwire.Lab",
    ),
    (
        'can.Bus(interface="canwire", channel="can0", can_filters=[(0x123, 0x7FF)])',
        'CanInitializationError: can_filters: (291, 2047) is no filter; one is {"can_id": 0x120, '
        '"can_mask": 0x7F0}',
    ),
    (
        "can_bus.send(frame)",
        'TypeError: msg Frame(0x123, bytes.fromhex("11")): must be can.Message, not Frame; '
        "can.Message(arbitration_id=0x123, data=[0x11], is_extended_id=False)",
    ),
    # calls with too many, missing or unknown arguments
    ('node.send(0x123, b"\\x11")', "TypeError: send() takes one frame: send(Frame(0x123, b'\\x11'))"),
    (
        "node.send(frame, 0.1)",
        "TypeError: send(): 0.1 is one argument too many; send(frame) does not wait for room",
    ),
    ("node.expect()", "TypeError: expect(): id is missing; for example node.expect(0x123, within=1.0)"),
    (
        "node.expect(0x123)",
        "TypeError: expect(): within is missing; for example node.expect(0x123, within=1.0)",
    ),
    (
        "node.expect(0x123, 1.0)",
        "TypeError: expect(): 1.0 is one argument too many; by name it takes within, extended, data; for "
        "example node.expect(0x123, within=1.0)",
    ),
    (
        "bus.faults.flip(9)",
        "TypeError: flip(): 9 is one argument too many; by name it takes bit, frame_id, extended, times, "
        "seen_by; for example faults.flip(bit=20, frame_id=0x123)",
    ),
    (
        "bus.faults.flip()",
        "TypeError: flip(): bit is missing; for example faults.flip(bit=20, frame_id=0x123)",
    ),
    (
        "bus.faults.flip(bit=9, id=0x123)",
        "TypeError: flip() has no argument 'id'; it has bit, frame_id, extended, times, seen_by; for "
        "example faults.flip(bit=20, frame_id=0x123)",
    ),
    ("bus.faults.noise()", "TypeError: noise(): bit_error_rate is missing; for example faults.noise(0.001)"),
    (
        "bus.faults.noise(rate=0.1)",
        "TypeError: noise() has no argument 'rate'; it has bit_error_rate; for example faults.noise(0.001)",
    ),
    (
        "bus.faults.disconnect()",
        "TypeError: disconnect(): node is missing; for example faults.disconnect(node)",
    ),
    (
        'bus.faults.inject("crc", 0x123)',
        "TypeError: inject(): 291 is one argument too many; by name it takes frame_id, extended, times; "
        'for example faults.inject("crc")',
    ),
    (
        "bus.faults.short(1)",
        "TypeError: short(): 1 is one argument too many; for example faults.short(), and "
        "faults.clear_short()",
    ),
    (
        "lab.can(500_000)",
        "AttributeError: Lab has no attribute 'can': a bus is made by lab.can_bus(\"can0\", "
        'bit_rate=500_000) or lab.lin_bus("lin0"); lab.buses has them',
    ),
    (
        'lab.can_bus("can1", 500_000)',
        "TypeError: can_bus(): 500000 is one argument too many; by name it takes bit_rate, "
        "data_bit_rate, timing, data_timing, iso_fd, length_m, node_delay_ns; for example "
        'lab.can_bus("can0", bit_rate=500_000)',
    ),
    (
        'lab.can_bus("can1", name="can1")',
        'TypeError: can_bus(): name is given twice; for example lab.can_bus("can0", bit_rate=500_000)',
    ),
    (
        'lab.lin_bus("lin1", 19_200)',
        "TypeError: lin_bus(): 19200 is one argument too many; by name it takes bit_rate, sleep_after; "
        'for example lab.lin_bus("lin0", bit_rate=19_200)',
    ),
    ("lab.run_for()", "TypeError: run_for(): seconds is missing; for example lab.run_for(0.5), in seconds"),
    (
        "lab.run_for(ms=5)",
        "TypeError: run_for() has no argument 'ms'; it has seconds; for example lab.run_for(0.5), in seconds",
    ),
    (
        "lab.run_until(seconds=1)",
        "TypeError: run_until() has no argument 'seconds'; it has time_ns; for example "
        "lab.run_until(5_000_000), in nanoseconds",
    ),
    (
        "lab.run_until_idle(1)",
        "TypeError: run_until_idle(): 1 is one argument too many; for example lab.run_until_idle()",
    ),
    ("bus.node()", 'TypeError: node(): name is missing; for example bus.node("engine")'),
    (
        "hub.boards()[0].send(frame)",
        "AttributeError: BoardInfo has no attribute 'send': a board's lines send and receive: "
        "hub.open_channel(board.id, 0) opens a channel on the first one",
    ),
    (
        "hub.boards()[0].open()",
        "AttributeError: BoardInfo has no attribute 'open': a board's lines send and receive: "
        "hub.open_channel(board.id, 0) opens a channel on the first one",
    ),
    (
        'hub.open("can0", 500000)',
        "AttributeError: Hub has no attribute 'open': canwire.find_lines(hub, \"can0\") finds lines, "
        "hub.open_channel(place.board.id, place.line) opens one",
    ),
    (
        "hub.open_channel(board)",
        "TypeError: open_channel(): line is missing; for example place = canwire.find_lines(hub, "
        '"can0")[0]; hub.open_channel(place.board.id, place.line)',
    ),
    (
        "hub.open_channel(board, 0, 500_000)",
        "TypeError: open_channel(): 500000 is one argument too many; by name it takes exclusive; for "
        'example place = canwire.find_lines(hub, "can0")[0]; hub.open_channel(place.board.id, place.line)',
    ),
    (
        "hub.open_control(board)",
        "TypeError: open_control(): line is missing; for example place = canwire.find_lines(hub, "
        '"can0")[0]; hub.open_control(place.board.id, place.line)',
    ),
    ("hub.board()", 'TypeError: board(): name is missing; for example hub.board("usb-to-can-fd")'),
    ("hub.plug()", 'TypeError: plug(): kind is missing; for example hub.plug("usb-to-can-fd")'),
    ("hub.bus()", 'TypeError: bus(): name is missing; for example hub.bus("can0")'),
    (
        "hub_bus.faults.flip(9)",
        "TypeError: flip(): 9 is one argument too many; by name it takes bit, frame_id, extended, times, "
        'seen_by; for example hub.bus("can0").faults.flip(bit=20, frame_id=0x123)',
    ),
    (
        "hub_bus.send(frame)",
        "AttributeError: HubBus has no attribute 'send': a bus neither sends nor receives, channels on "
        'its lines do: canwire.find_lines(hub, "can0") finds lines, hub.open_channel(place.board.id, '
        "place.line) opens one",
    ),
    (
        "channel.set_up(16, 16)",
        "TypeError: set_up(): 16 is one argument too many; for example "
        "channel.set_up(canwire.ChannelMode(receive=1024, transmit=256))",
    ),
    (
        "channel.set_up(receive=16)",
        "TypeError: set_up() has no argument 'receive'; it has mode; for example "
        "channel.set_up(canwire.ChannelMode(receive=1024, transmit=256))",
    ),
    (
        "control.initialise(timing=5)",
        "TypeError: initialise() has no argument 'timing'; it has mode; for example "
        "control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, "
        "clock_hz=80_000_000)))",
    ),
    (
        "control.start(5)",
        "TypeError: start(): 5 is one argument too many; by name it takes abort_pending; for example "
        "control.start()",
    ),
    (
        "LineMode(5)",
        "TypeError: timing 5: must be BitTiming or None; BitTiming.for_bit_rate(500_000, "
        "clock_hz=80_000_000) makes one",
    ),
    (
        'LineMode("500k")',
        "TypeError: timing '500k': must be BitTiming or None; BitTiming.for_bit_rate(500_000, "
        "clock_hz=80_000_000) makes one",
    ),
    (
        "LineMode()",
        "TypeError: LineMode(): timing is missing; for example "
        "canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000))",
    ),
    (
        "ChannelMode()",
        "TypeError: ChannelMode(): receive is missing; for example canwire.ChannelMode(receive=1024, "
        "transmit=256)",
    ),
    (
        "ChannelMode(rx=16)",
        "TypeError: ChannelMode() has no argument 'rx'; it has receive, transmit, exact, ticks, "
        "filter_mode, filter_size, siblings, events, frames, fd, prioritised, confirms, kin; for example "
        "canwire.ChannelMode(receive=1024, transmit=256)",
    ),
    (
        'master.send(0x10, b"1")',
        "TypeError: send(): b'1' is one argument too many; for example "
        'master.send(canwire.LinFrame(0x10, b"\\x11"))',
    ),
    (
        'open_log("a.blf", "r")',
        "TypeError: open_log(): 'r' is one argument too many; by name it takes format, limits; for "
        'example canwire.open_log("drive.blf")',
    ),
    (
        'open_log("a.blf", mode="r")',
        "TypeError: open_log() has no argument 'mode'; it has path, format, limits; for example "
        'canwire.open_log("drive.blf")',
    ),
    (
        'create_log("a.blf", "w")',
        "TypeError: create_log(): 'w' is one argument too many; by name it takes format, dated, "
        'start_ns, clock, whole; for example canwire.create_log("drive.blf")',
    ),
    (
        'load_database("a.dbc", "b.dbc")',
        "TypeError: load_database(): 'b.dbc' is one argument too many; by name it takes encoding, "
        'strict, j1939, most_bytes, seconds; for example canwire.load_database("engine.dbc")',
    ),
    (
        'db.encode("EngineData", EngineSpeed=5)',
        "TypeError: encode() has no argument 'EngineSpeed'; it has name, signals, fill, source, "
        'destination, priority; for example db.encode("EngineData", {"EngineSpeed": 1500})',
    ),
    (
        'db.decode(0x100, b"12345678")',
        "TypeError: decode(): b'12345678' is one argument too many; for example db.decode(frame), with a "
        "canwire.Frame",
    ),
    (
        'find_lines("can0")',
        'TypeError: find_lines(): name is missing; for example canwire.find_lines(hub, "can0")',
    ),
    (
        'start_line(hub, "can0")',
        "TypeError: start_line(): mode is missing; for example place = canwire.find_lines(hub, "
        '"can0")[0]; canwire.start_line(hub, place, '
        "canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))",
    ),
    (
        'connect("a", "b")',
        "TypeError: connect(): 'b' is one argument too many; by name it takes time, config, name, timed; "
        'for example canwire.connect(), or canwire.connect(time="virtual") for a hub of this program '
        "alone",
    ),
    (
        'connect(host="127.0.0.1")',
        "TypeError: connect() has no argument 'host'; it has address, time, config, name, timed; for "
        'example canwire.connect(), or canwire.connect(time="virtual") for a hub of this program alone',
    ),
    (
        'Lab("real")',
        "TypeError: Lab(): 'real' is one argument too many; by name it takes time, seed; for example "
        'canwire.Lab(), or canwire.Lab(time="real")',
    ),
    (
        "campaign(5)",
        "TypeError: campaign(): 5 is one argument too many; for example @canwire.campaign(load=[0.1, "
        "0.5]) before def run(lab, load)",
    ),
]


@pytest.mark.parametrize(("mistake", "answer"), MISTAKES, ids=[mistake for mistake, _ in MISTAKES])
def test_it_is_answered(
    mistake: str, answer: str, names: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    with pytest.raises((AttributeError, TypeError, canwire.CanwireError, names["can"].CanError)) as caught:
        eval(mistake, names)
    assert f"{type(caught.value).__name__}: {caught.value}".replace(ROOT.as_posix(), "ROOT") == answer


def test_no_row_ends_in_a_bare_error_of_python() -> None:
    bare = (
        "object has no attribute",
        "not supported between",
        "unexpected keyword",
        "is not iterable",
        "format code",
        "positional argument",
        "keyword-only argument",
    )
    assert [mistake for mistake, answer in MISTAKES if any(part in answer for part in bare)] == []


def test_wrong_names_are_not_there_for_those_who_look() -> None:
    assert not hasattr(canwire.Frame(1), "arbitration_id")
    assert not hasattr(canwire, "Bus")


def test_an_object_may_go_to_another_node_once_its_own_has_left() -> None:
    script = Quiet()
    with canwire.Lab() as lab:
        first = lab.can_bus("can0").node("first", script)
        first.close()
        lab.buses["can0"].node("second", script)
    with canwire.Lab() as lab:
        assert lab.can_bus("can0").node("third", script) is script.node


@pytest.mark.parametrize(("data_bit_rate", "last"), [(None, 156), (2_000_000, 732)])
def test_the_last_bit_that_a_fault_may_name_is_beyond_the_longest_frame(
    data_bit_rate: int | None, last: int
) -> None:
    fd = data_bit_rate is not None
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=data_bit_rate)
        bus.node("engine")
        for data in (bytes(64 if fd else 8), bytes([0x3C] * (64 if fd else 8))):
            layout = canwire.BitLayout(canwire.Frame(0, data, extended=True, fd=fd))
            assert len(layout.levels) <= last + 1
        bus.faults.flip(bit=last)
        with pytest.raises(canwire.BadValue, match=f"ends with bit {last}"):
            bus.faults.flip(bit=last + 1)
