"""Hostile programs of the soak: each says that it has begun, and goes on until it is killed."""

from __future__ import annotations

BEGIN = """
import os, random, sys, threading, time, canwire
hub = canwire.connect(sys.argv[1], name=sys.argv[2])
board = hub.boards()[1].id
channel = hub.open_channel(board, 0)
channel.set_up(canwire.ChannelMode(64, 4096))
channel.activate()
"""
GO = "print('at it', flush=True)\n"
HOSTILE = {  # programs that go on until they are killed
    "reader": BEGIN + GO + "while True: channel.receive(1)",
    "caller": BEGIN + GO + "while True: hub.boards(), hub.line_status(board, 0)",
    "opener": BEGIN + GO + "while True:\n x = hub.open_channel(board, 0)\n"
    + " x.set_up(canwire.ChannelMode(64, 64))\n x.close()",
    "holder": BEGIN + "hub.open_scheduler(board, 0); hub.create_fifo(99, 99); hub.keep_settings(board, 0)\n" + GO
    + "time.sleep(99)",
    "vci": "import os, sys, time\nos.environ['CANWIRE_HUB'] = sys.argv[1]\nimport canwire.vci as vci\n"
    "vci.initialize()\nmanager = vci.get_device_manager()\n" + GO + "time.sleep(99)",
    "python-can": "import sys\nfrom canwire.python_can import CanwireBus\nbus = CanwireBus('can1', hub=sys.argv[1])\n"
    + GO + "while True: bus.recv(1)",
    "flood": BEGIN + GO
    + "def go():\n while True: hub.create_luid()\nfor _ in range(8): threading.Thread(target=go).start()",
    "rubbish": BEGIN + GO + "while True:\n channel.writing.ring.put_bytes(os.urandom(80)); hub.doorbell.signal()",
    "slow reader": BEGIN + GO + "time.sleep(99)",
    "spoiler": BEGIN + GO + """
for fd in (hub.doorbell.fileno(), channel.reading.descriptor.fileno(), channel.writing.descriptor.fileno()):
    os.set_blocking(fd, False)
    try:
        while True: os.write(fd, b'x' * 8)
    except BlockingIOError: os.set_blocking(fd, True)
time.sleep(99)
""",
    "forged ring": BEGIN + GO + """
words = memoryview(channel.writing.ring.acquire_free(1).obj).cast('B').cast('Q')
while True:
    words[random.randrange(len(words))] = random.getrandbits(64); hub.doorbell.signal()
""",
    "forker": BEGIN + GO + "while True:\n pid = os.fork()\n if not pid: os._exit(0)\n os.waitpid(pid, 0)",
}  # fmt: skip
