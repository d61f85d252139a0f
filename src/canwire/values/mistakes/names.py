"""Names that people try and that canwire does not have: what to write instead.

They come from python-can, cantools and other libraries. A class gets them as descriptors that raise AttributeError when
they are read, because a `__getattr__` would slow down every attribute: on Python 3.11 a node's send and receive by a
quarter. Python's own traceback suggests the nearest name for other misspellings.
"""

from __future__ import annotations

from typing import Never, TypeVar

from canwire.values.mistakes.calls import EXAMPLES, answers_wrong_calls

KindT = TypeVar("KindT", bound=type)

_NODE_RECEIVES = (
    "a node receives by node.receive(timeout), and node.expect(0x123, within=1.0) waits for one frame"
)
_NODE_SENDS = 'a node sends by node.send(canwire.Frame(0x123, b"\\x11"))'
_NODE_REPEATS = "a script sends in cycles: `self.every(0.1, self.report)` in on_start of a canwire.NodeScript"
_NODE_FILTERS = "filters are given when the node is made: bus.node(name, filters=[(0x120, 0x7F0)])"
_NODE_CALLS = (
    "a script has on_message(frame): bus.node(name, MyScript()) with a class made from canwire.NodeScript"
)
_BUS_SPEAKS = 'a bus neither sends nor receives, its nodes do: node = bus.node("tester"), then '
_BUS_RATE = "its bit rate is bus.timing.bit_rate"
_LAB_TIME = "time passes by lab.run_for(seconds), lab.run_until(time_ns) or lab.run_until_idle()"
_LAB_BUS = 'a bus is made by lab.can_bus("can0", bit_rate=500_000) or lab.lin_bus("lin0"); lab.buses has them'
_CHANNEL_RECEIVES = "a channel receives by channel.receive(timeout), after set_up(...) and activate()"
_HUB_LINE = (
    'canwire.find_lines(hub, "can0") finds lines, hub.open_channel(place.board.id, place.line) opens one'
)
_BOARD_SPEAKS = (
    "a board's lines send and receive: hub.open_channel(board.id, 0) opens a channel on the first one"
)
_HUB_BUS_SPEAKS = f"a bus neither sends nor receives, channels on its lines do: {_HUB_LINE}"
_CONTROL_SETS_UP = "a line is set up by control.initialise(canwire.LineMode(timing)), then control.start()"
_DB_ENCODES = 'db.encode("EngineData", {"EngineSpeed": 1500}) makes a frame'
_DB_DECODES = "db.decode(frame) takes a canwire.Frame"
_DB_FILE = "one Database is one file: canwire.load_database(path)"
_FAULT_FLIPS = 'a bit is inverted by faults.flip(bit=20), an error provoked by faults.inject("crc")'
_LIN_NODES = "nodes of a LIN bus are made by bus.master(name) and bus.slave(name)"

OF_CLASSES: dict[str, dict[str, str]] = {
    "Lab": {
        "bus": _LAB_BUS,
        "add_bus": _LAB_BUS,
        "create_bus": _LAB_BUS,
        "can": _LAB_BUS,
        "lin": _LAB_BUS,
        "node": 'nodes are on a bus: lab.can_bus("can0").node("engine")',
        "add_node": 'nodes are on a bus: lab.can_bus("can0").node("engine")',
        "step": _LAB_TIME,
        "wait": _LAB_TIME,
        "start": f"a lab needs no start: {_LAB_TIME}",
        "stop": "a lab ends with its `with` block, or by lab.close()",
        "advance_time": _LAB_TIME,
        "time": "the lab's time is lab.now_ns, in nanoseconds",
        "now": "the lab's time is lab.now_ns, in nanoseconds",
    },
    "LabBus": {
        "send": f"{_BUS_SPEAKS}node.send(frame)",
        "recv": f"{_BUS_SPEAKS}node.receive(timeout)",
        "receive": f"{_BUS_SPEAKS}node.receive(timeout)",
        "add_node": 'bus.node("engine") makes a node',
        "attach": 'bus.node("engine") makes a node',
        "connect": 'bus.node("engine") makes a node',
        "bitrate": _BUS_RATE,
        "bit_rate": _BUS_RATE,
        "shutdown": "a bus ends with its lab: lab.close()",
        "set_filters": _NODE_FILTERS,
        "send_periodic": _NODE_REPEATS,
        "flip": "what goes wrong on a bus is bus.faults: bus.faults.flip(bit=20)",
        "state": "a state is a node's: node.state",
        "master": "a CAN bus has no master: bus.node(name); LIN's is lab.lin_bus().master(name)",
        "slave": "a CAN bus has no slaves: bus.node(name); LIN's are lab.lin_bus().slave(name)",
    },
    "LabLinBus": {
        "node": _LIN_NODES,
        "add_node": _LIN_NODES,
        "send": f"{_LIN_NODES}; the master sends by node.send(frame) and asks by node.ask(id)",
        "recv": f"{_LIN_NODES}; node.receive(timeout) receives",
        "receive": f"{_LIN_NODES}; node.receive(timeout) receives",
    },
    "BenchNode": {
        "recv": _NODE_RECEIVES,
        "read": _NODE_RECEIVES,
        "get": _NODE_RECEIVES,
        "recieve": _NODE_RECEIVES,
        "write": _NODE_SENDS,
        "transmit": _NODE_SENDS,
        "put": _NODE_SENDS,
        "send_message": 'messages have names by a database: db.on(node).send_message("EngineData", EngineSpeed=1500)',
        "expect_message": 'messages have names by a database: db.on(node).expect_message("EngineData", within=1.0)',
        "send_periodic": _NODE_REPEATS,
        "every": _NODE_REPEATS,
        "set_filters": _NODE_FILTERS,
        "add_filter": _NODE_FILTERS,
        "on_message": _NODE_CALLS,
        "on_receive": _NODE_CALLS,
        "on_recieve": _NODE_CALLS,
        "add_listener": _NODE_CALLS,
        "shutdown": "a node leaves its bus by node.close()",
        "now_ns": "time is the lab's: node.time.now_ns",
    },
    "Hub": {
        "line": _HUB_LINE,
        "lines": _HUB_LINE,
        "open": _HUB_LINE,
        "channel": _HUB_LINE,
        "can_bus": 'a hub\'s buses are in its canwire.toml; hub.bus("can0") is one of them',
        "buses": "canwire.every_line(hub) lists lines with their buses",
        "send": f"frames go through a channel: {_HUB_LINE}",
        "recv": f"frames come through a channel: {_HUB_LINE}",
        "receive": f"frames come through a channel: {_HUB_LINE}",
        "start": f"a line is started by its control: hub.open_control(board, line); {_CONTROL_SETS_UP}",
        "shutdown": "a connection ends by hub.close()",
        "disconnect": "a connection ends by hub.close()",
    },
    "HubBus": {
        "send": _HUB_BUS_SPEAKS,
        "recv": _HUB_BUS_SPEAKS,
        "receive": _HUB_BUS_SPEAKS,
        "flip": 'what goes wrong on a bus is bus.faults: hub.bus("can0").faults.flip(bit=20)',
    },
    "BoardInfo": {
        "send": _BOARD_SPEAKS,
        "recv": _BOARD_SPEAKS,
        "receive": _BOARD_SPEAKS,
        "open": _BOARD_SPEAKS,
        "start": "a line is started by its control: hub.open_control(board.id, 0)",
    },
    "HubChannel": {
        "recv": _CHANNEL_RECEIVES,
        "read": _CHANNEL_RECEIVES,
        "recieve": _CHANNEL_RECEIVES,
        "write": "a channel sends by channel.send(frame)",
        "transmit": "a channel sends by channel.send(frame)",
        "start": "a channel begins by channel.activate(), its line by hub.open_control(board, line).start()",
        "set_filters": "channel.replace_filters(standard, extended) sets filters",
        "shutdown": "a channel ends by channel.close()",
    },
    "Control": {
        "init": _CONTROL_SETS_UP,
        "initialize": _CONTROL_SETS_UP,
        "init_line": _CONTROL_SETS_UP,
        "set_bitrate": _CONTROL_SETS_UP,
        "send": f"frames go through a channel: {_HUB_LINE}",
    },
    "Database": {
        "encode_message": _DB_ENCODES,
        "decode_message": _DB_DECODES,
        "get_message_by_name": 'db.message("EngineData") gives a message by its name',
        "get_message_by_frame_id": "db.message_of(frame) gives the message that a frame is",
        "add_dbc": _DB_FILE,
        "add_dbc_file": _DB_FILE,
        "add_dbc_string": _DB_FILE,
        "load_file": _DB_FILE,
        "buses": "node names are db.nodes, messages db.messages",
    },
    "LabFaults": {
        "flip_bit": _FAULT_FLIPS,
        "invert": _FAULT_FLIPS,
        "error": _FAULT_FLIPS,
        "corrupt": _FAULT_FLIPS,
        "drop": "a frame is destroyed by faults.flip(bit=20, frame_id=0x123), and then repeated, as on copper",
        "unplug": "a node's plug is pulled by faults.disconnect(node)",
        "plug": "a node's plug is put back by faults.reconnect(node)",
        "bus_off": "faults.flip(bit=20, frame_id=0x123, times=32) drives the sender to bus-off",
    },
    "BitTiming": {
        "from_sample_point": "BitTiming.for_bit_rate(500_000, sample_point=0.8, clock_hz=80_000_000) calculates one",
        "from_bitrate": "BitTiming.for_bit_rate(500_000, clock_hz=80_000_000) calculates one",
        "bitrate": "the bit rate is timing.bit_rate, in bit/s",
        "brp": "the prescaler is timing.prescaler",
    },
    "Frame": {
        "arbitration_id": "the identifier is frame.id",
        "is_extended_id": "that is frame.extended",
        "is_remote_frame": "that is frame.remote",
        "is_fd": "that is frame.fd",
        "bitrate_switch": "that is frame.bit_rate_switch",
        "timestamp": "the time is frame.timestamp_ns, in nanoseconds",
        "length": "the length is len(frame.data), the code on the wire frame.dlc",
        "payload": "the bytes are frame.data",
    },
}
"""By the class that has them; classes made from it have them too."""

_LOGS = (
    'canwire.open_log("drive.blf") reads logs of every format, canwire.create_log("drive.blf") writes them'
)
_LAB = 'lab = canwire.Lab() and bus = lab.can_bus("can0", bit_rate=500_000) make a bus'
_CAN_BUS = f'python-can\'s bus is can.Bus(interface="canwire", channel="can0"); without python-can, {_LAB}'
_FRAME = 'a frame is canwire.Frame(0x123, b"\\x11\\x22")'
_MADE_BY_BUS = 'a node is made by its bus: canwire.Lab().can_bus("can0").node("engine")'
_NOT_HERE = 'is python-can\'s, and works with can.Bus(interface="canwire", channel="can0")'
OF_THE_DOOR = {
    "Bus": _CAN_BUS,
    "CanBus": _CAN_BUS,
    "VirtualBus": _CAN_BUS,
    "ThreadSafeBus": _CAN_BUS,
    "LinBus": 'a LIN bus is made by canwire.Lab().lin_bus("lin0")',
    "Message": f'{_FRAME}; can.Message is python-can\'s, for can.Bus(interface="canwire")',
    "CanFrame": _FRAME,
    "CANFrame": _FRAME,
    "CanMessage": _FRAME,
    "frame": _FRAME,
    "Node": _MADE_BY_BUS,
    "ECU": f"{_MADE_BY_BUS}; small ECUs for UDS, CANopen and J1939 are in canwire.ecus",
    "Script": "a node's behaviour is a class made from canwire.NodeScript",
    "Simulation": 'db.simulated("Engine") plays a node of a database: bus.node("engine", db.simulated("Engine"))',
    "simulate": 'db.simulated("Engine") plays a node of a database; the command is `canwire simulate`',
    "database": "a description of a network is read by canwire.load_database(path)",
    "load_file": "a description of a network is read by canwire.load_database(path)",
    "load_dbc": "a description of a network is read by canwire.load_database(path)",
    "Notifier": f"Notifier {_NOT_HERE}",
    "Listener": f"Listener {_NOT_HERE}",
    "BufferedReader": f"BufferedReader {_NOT_HERE}",
    "AsyncBufferedReader": "async code receives by `await node.receive_async()`",
    "LogReader": _LOGS,
    "Logger": "canwire.record(line, path) writes what a line hears",
    "Printer": "canwire.format_frame(frame) is a frame as text; the command is `canwire dump can0`",
    "BLFReader": _LOGS,
    "BLFWriter": _LOGS,
    "ASCReader": _LOGS,
    "ASCWriter": _LOGS,
    "MF4Reader": _LOGS,
    "TRCReader": _LOGS,
    "CSVReader": _LOGS,
    "read_log": _LOGS,
    "load_log": _LOGS,
    "open": f"canwire.connect() opens a hub; {_LOGS}",
    "isotp": "docs/how-to/isotp.md sends messages longer than a frame; the command is `canwire isotp`",
    "uds": "a small UDS ECU is in canwire.ecus; `canwire uds` asks one",
    "detect_available_configs": "the lines of a hub are canwire.every_line(hub); the command is `canwire devices`",
    "CanError": "every error is a canwire.CanwireError; can.CanError is python-can's",
    "Error": "every error is a canwire.CanwireError",
    "virtual": "virtual time is the lab's, canwire.Lab(), or a hub's: canwire.connect(time=\"virtual\")",
}


class WrongName:
    """Read from an object, or called as a class's method, it raises AttributeError with the advice.

    Read from a class it is itself, as a property is: for tools that walk over all names of a class.
    """

    def __init__(self, owner: str, name: str) -> None:
        self._words = (owner, name)

    def __get__(self, instance: object, kind: type) -> WrongName:
        if instance is None:
            return self
        raise self._error(kind.__name__)

    def __call__(self, *_: object, **__: object) -> Never:
        raise self._error(self._words[0])

    def _error(self, kind: str) -> AttributeError:
        owner, name = self._words
        return AttributeError(f"{kind} has no attribute {name!r}: {OF_CLASSES[owner][name]}")


def answers_wrong_names(kind: KindT) -> KindT:
    """Add the class's rows of this table and of the table of calls to it; existing attributes are unchanged."""
    for name in OF_CLASSES.get(kind.__name__, ()):
        if not hasattr(kind, name):
            setattr(kind, name, WrongName(kind.__name__, name))
    for name in EXAMPLES.get(kind.__name__, ()):
        setattr(kind, name, answers_wrong_calls(getattr(kind, name), kind.__name__, name))
    return kind
