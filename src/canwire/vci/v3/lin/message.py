"""LinMessage.

Source: VCI V3 .NET manual 4.3.3.1 and 4.3.4.2; reference/vci.md section 7a.
"""

from __future__ import annotations

from canwire.vci.arguments import UINT8
from canwire.vci.lin.message import LinMsg
from canwire.vci.v3.errors import checked
from canwire.vci.v3.lin.enums import LinMessageType, LinMsgError
from canwire.vci.v3.message import LONGEST, Message


class LinMessage(Message[LinMsg]):
    """A LIN message of up to 8 bytes; a new one is a data message without data. `message[i]` is byte i, 0 to 7.

    `raw` is V4's structure. Assigning an invalid value raises ArgumentOutOfRangeException.
    """

    __slots__ = ()

    def __init__(self) -> None:
        self.raw = LinMsg()

    @property
    def prot_id(self) -> int:
        """ProtId: the identifier, 0 to 63, with the parity bits above it; 0xFF if the message is not about a frame."""
        return self.raw.msg_info.pid

    @prot_id.setter
    def prot_id(self, identifier: int) -> None:
        self.raw.msg_info.pid = checked("prot_id", identifier, UINT8)

    @property
    def message_type(self) -> LinMessageType:
        """MessageType; only DATA, SLEEP and WAKEUP are sent."""
        return LinMessageType(self.raw.msg_info.type)

    @message_type.setter
    def message_type(self, kind: int) -> None:
        self.raw.msg_info.type = checked("message_type", kind, max(LinMessageType))

    @property
    def data_length(self) -> int:
        """DataLength in bytes, 0 to 8; in TIME_OVERRUN the number of overflows of the counter."""
        return self.raw.msg_info.dlen

    @data_length.setter
    def data_length(self, length: int) -> None:
        self.raw.msg_info.dlen = checked("data_length", length, LONGEST)

    @property
    def extended_crc(self) -> bool:
        """ExtendedCrc: the checksum includes the identifier, as in LIN 2.0."""
        return bool(self.raw.msg_info.ecs)

    @extended_crc.setter
    def extended_crc(self, extended: bool) -> None:
        self.raw.msg_info.ecs = bool(extended)

    @property
    def sender_of_response(self) -> bool:
        """SenderOfResponse: this controller sent the response, from its table."""
        return bool(self.raw.msg_info.sor)

    @sender_of_response.setter
    def sender_of_response(self, sender: bool) -> None:
        self.raw.msg_info.sor = bool(sender)

    @property
    def id_only(self) -> bool:
        """IdOnly: a master sends only the header, and a slave answers with `data_length` bytes."""
        return bool(self.raw.msg_info.ido)

    @id_only.setter
    def id_only(self, alone: bool) -> None:
        self.raw.msg_info.ido = bool(alone)

    def __repr__(self) -> str:
        info = self.raw.msg_info
        kind = LinMessageType(info.type)
        shown = self.raw.data if kind is LinMessageType.DATA else bytes(self.raw.ab_data)
        return f"<LinMessage {kind.name.lower()} {info.pid:#x} [{info.dlen}] {shown.hex(' ')}>"


def received(raw: LinMsg, message: LinMessage | None = None) -> LinMessage:
    """V3's message for V4's message, in `message` if that is given; an error gets V3's number."""
    made = LinMessage() if message is None else message
    if raw.msg_info.type == LinMessageType.ERROR:
        raw.ab_data[0] = LinMsgError(raw.ab_data[0])
    made.raw = raw
    return made
