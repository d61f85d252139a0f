"""Numbers of the kernel's SocketCAN.

Source: linux/can.h, linux/can/raw.h, linux/can/bcm.h, linux/can/isotp.h,
linux/can/j1939.h (Debian's linux-libc-dev 6.1).
"""

from __future__ import annotations

AF_CAN = 29
CAN_RAW, CAN_BCM, CAN_ISOTP, CAN_J1939 = 1, 2, 6, 7
SOCK_DGRAM, SOCK_RAW = 2, 3
TYPE_OF_PROTOCOL = {CAN_RAW: SOCK_RAW, CAN_BCM: SOCK_DGRAM, CAN_ISOTP: SOCK_DGRAM, CAN_J1939: SOCK_DGRAM}

CAN_EFF_FLAG = 0x8000_0000
CAN_RTR_FLAG = 0x4000_0000
CAN_ERR_FLAG = 0x2000_0000
CAN_SFF_MASK = 0x0000_07FF
CAN_EFF_MASK = 0x1FFF_FFFF
CAN_ERR_MASK = 0x1FFF_FFFF
CAN_INV_FILTER = 0x2000_0000

CAN_MTU, CANFD_MTU = 16, 72
CANFD_BRS, CANFD_ESI = 0x01, 0x02

SOL_CAN_BASE = 100
SOL_CAN_RAW = SOL_CAN_BASE + CAN_RAW
SOL_CAN_ISOTP = SOL_CAN_BASE + CAN_ISOTP
SOL_CAN_J1939 = SOL_CAN_BASE + CAN_J1939

CAN_RAW_FILTER = 1
CAN_RAW_ERR_FILTER = 2
CAN_RAW_LOOPBACK = 3
CAN_RAW_RECV_OWN_MSGS = 4
CAN_RAW_FD_FRAMES = 5
CAN_RAW_JOIN_FILTERS = 6
MOST_FILTERS = 512

SOCKADDR_CAN = (
    "<HxxiII8x"  # family, index, then what a protocol makes of it: receive and transmit identifiers
)
SOCKADDR_CAN_SHORTEST = 8  # family and index: what CAN_RAW and CAN_BCM need
