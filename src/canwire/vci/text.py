"""Conversion between LUIDs, GUIDs and text.

Source: VCI V4 manual 6.1.5 to 6.1.8; reference/vci.md section 10. The manual contains the sizes, 17 and 39 with the
final NUL. It does not define the order of the LUID's digits; canwire writes the high part first, then the low part.
"""

from __future__ import annotations

import re
from uuid import UUID

from canwire.vci.structures.devices import VciId
from canwire.vci.structures.errors import VCI_E_BUFFER_OVERFLOW, VCI_E_FAIL, VCI_E_INVALIDARG, VciError

_LUID = re.compile(r"[0-9A-Fa-f]{16}")
_GUID = re.compile(r"\{([0-9A-Fa-f]{8}(?:-[0-9A-Fa-f]{4}){3}-[0-9A-Fa-f]{12})\}")


def luid_to_char(vciid: VciId, size: int = 17) -> str:
    """VciLuidToChar: 16 hex digits, high part first, for a buffer of `size` characters.

    Raises VciBufferOverflow if `size` is below 17, VciInvalidArgument for anything but a VciId.

    >>> luid_to_char(VciId(as_int64=0x10002))
    '0000000000010002'
    """
    if not isinstance(vciid, VciId):
        raise VciError(VCI_E_INVALIDARG, "luid_to_char needs a VciId")
    return _fitting(vciid.to_bytes()[::-1].hex().upper(), size)


def char_to_luid(text: str) -> VciId:
    """VciCharToLuid: the identifier from 16 hex digits in upper or lower case.

    Raises VciFail for any other text, VciInvalidArgument for anything but a str.
    """
    digits = _match(_LUID, text, "16 hex digits")[0]
    return VciId.from_bytes(bytes.fromhex(digits)[::-1])


def guid_to_char(guid: UUID, size: int = 39) -> str:
    """VciGuidToChar: the GUID in braces and in upper case, for a buffer of `size` characters.

    Raises VciBufferOverflow if `size` is below 39, VciInvalidArgument for anything but a UUID.

    >>> guid_to_char(UUID(int=0x46))
    '{00000000-0000-0000-0000-000000000046}'
    """
    if not isinstance(guid, UUID):
        raise VciError(VCI_E_INVALIDARG, "guid_to_char needs a uuid.UUID")
    return _fitting(f"{{{guid}}}".upper(), size)


def char_to_guid(text: str) -> UUID:
    """VciCharToGuid: the GUID from a text with braces and hyphens, in upper or lower case.

    Raises VciFail for any other text, VciInvalidArgument for anything but a str.
    """
    return UUID(_match(_GUID, text, "{XXXXXXXX-XXXX-XXXX-XXXX-XXXXXXXXXXXX}")[1])


def _fitting(text: str, size: int) -> str:
    if not isinstance(size, int):
        raise VciError(VCI_E_INVALIDARG, "the size of a buffer must be a whole number")
    if size <= len(text):
        raise VciError(VCI_E_BUFFER_OVERFLOW, f"{len(text) + 1} characters with the final NUL")
    return text


def _match(pattern: re.Pattern[str], text: str, form: str) -> re.Match[str]:
    if not isinstance(text, str):
        raise VciError(VCI_E_INVALIDARG, "the text must be a str")
    found = pattern.fullmatch(text.partition("\0")[0])
    if found is None:
        raise VciError(VCI_E_FAIL, f"{text!r:.60} is not {form}")
    return found
