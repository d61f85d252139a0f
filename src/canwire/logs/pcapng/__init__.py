"""pcapng, which Wireshark and tshark read: CAN as SocketCAN packets (link type 227), LIN by link type 212.

What no packet can say (marks, LIN events) stands in interface statistics blocks as a comment, which others skip; a lost
count is their "packets dropped by the interface", too. Older pcap files are read.

Source: IETF draft-ietf-opsawg-pcapng; tcpdump.org/linktypes (LINKTYPE_CAN_SOCKETCAN, LINKTYPE_LIN).
"""

from canwire.logs.pcapng.reading import read, recognises
from canwire.logs.pcapng.writing import Writer

__all__ = ["Writer", "read", "recognises"]
