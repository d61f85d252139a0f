"""VciServer and the message factory of Ixxat.Vci4; devices and their lists are V3's.

Source: the vendor's published contract of Ixxat.Vci4.
"""

from __future__ import annotations

from typing import ClassVar, TypeVar

from canwire.vci import server
from canwire.vci.net4.message import CanMessage, CanMessage2
from canwire.vci.structures.errors import VCI_E_INVALIDARG
from canwire.vci.v3.device_info import Version
from canwire.vci.v3.errors import ArgumentException
from canwire.vci.v3.lin.message import LinMessage
from canwire.vci.v3.server import VciServer as V3Server

Message = TypeVar("Message", CanMessage, CanMessage2, LinMessage)


class MessageFactory:
    """IMessageFactory."""

    @staticmethod
    def create_msg(kind: type[Message]) -> Message:
        """CreateMsg: an empty message of ICanMessage, ICanMessage2 or ILinMessage; raises ArgumentException."""
        if kind not in (CanMessage, CanMessage2, LinMessage):
            raise ArgumentException(
                VCI_E_INVALIDARG, f"{kind!r:.60}: use ICanMessage, ICanMessage2 or ILinMessage"
            )
        return kind()


class VciServer(V3Server):
    """VciServer, of which each process has one."""

    _instance: ClassVar[VciServer | None] = None

    @classmethod
    def instance(cls) -> VciServer:
        """Instance: the server of this process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    @property
    def msg_factory(self) -> MessageFactory:
        """MsgFactory."""
        return MessageFactory()

    @property
    def version(self) -> Version:
        """Version: the version of VCI."""
        info = server.get_version()
        return Version(
            info.vci_major_version, info.vci_minor_version, info.vci_rev_number, info.vci_build_number
        )
