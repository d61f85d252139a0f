"""pcapng, the format of Wireshark and tshark: CAN as SocketCAN packets (link type 227), LIN by link type 212.

Data that no packet can hold (marks, LIN events) are comments in interface statistics blocks, which other programs
ignore; a count of lost frames is also in "packets dropped by the interface" of such a block. Older pcap files are read.

Source: IETF draft-ietf-opsawg-pcapng; tcpdump.org/linktypes (LINKTYPE_CAN_SOCKETCAN, LINKTYPE_LIN).
"""

from canwire.logs.pcapng.reading import read, recognises
from canwire.logs.pcapng.writing import Writer

__all__ = ["Writer", "read", "recognises"]
