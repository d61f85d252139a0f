"""Result codes: numbers copied from reference/vci.md section 1."""

from __future__ import annotations

import copy
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import CanwireError
from canwire.vci.structures import errors
from canwire.vci.structures.errors import VciError, VciInvalidArgument, VciTimeout, format_error
from tests.cases import each

# in the order of their numbers, from E0010001
CODES = """
UNEXPECTED NOT_IMPLEMENTED OUTOFMEMORY INVALIDARG NOINTERFACE INVPOINTER INVHANDLE ABORT FAIL
ACCESSDENIED TIMEOUT BUSY PENDING NO_DATA NO_MORE_ITEMS NOT_INITIALIZED ALREADY_INITIALIZED
RXQUEUE_EMPTY TXQUEUE_FULL BUFFER_OVERFLOW INVALID_STATE OBJECT_ALREADY_EXISTS INVALID_INDEX
END_OF_FILE DISCONNECTED INVALID_FIRMWARE INVALID_LICENSE NO_SUCH_LICENSE LICENSE_EXPIRED
LICENSE_QUOTA_EXCEEDED INVALID_TIMING IN_USE NO_SUCH_DEVICE DEVICE_NOT_CONNECTED DEVICE_NOT_READY
TYPE_MISMATCH NOT_SUPPORTED DUPLICATE_OBJECTID OBJECTID_NOT_FOUND WRONG_LEVEL WRONG_DRV_VERSION
LUIDS_EXHAUSTED
"""
NUMBERED = [(f"VCI_E_{name}", 0xE0010001 + at) for at, name in enumerate(CODES.split())]
# a few of them once more, with the number as the reference prints it
SPOT_CHECKS = [
    ("VCI_E_ACCESSDENIED", 0xE001000A),
    ("VCI_E_TXQUEUE_FULL", 0xE0010013),
    ("VCI_E_DISCONNECTED", 0xE0010019),
    ("VCI_E_IN_USE", 0xE0010020),
    ("VCI_E_NOT_SUPPORTED", 0xE0010025),
    ("VCI_E_LUIDS_EXHAUSTED", 0xE001002A),
]
SUBCLASSES = {
    "VciAccessDenied": errors.VCI_E_ACCESSDENIED,
    "VciBufferOverflow": errors.VCI_E_BUFFER_OVERFLOW,
    "VciBusy": errors.VCI_E_BUSY,
    "VciDeviceNotConnected": errors.VCI_E_DEVICE_NOT_CONNECTED,
    "VciDisconnected": errors.VCI_E_DISCONNECTED,
    "VciFail": errors.VCI_E_FAIL,
    "VciInvalidArgument": errors.VCI_E_INVALIDARG,
    "VciInvalidIndex": errors.VCI_E_INVALID_INDEX,
    "VciInvalidState": errors.VCI_E_INVALID_STATE,
    "VciNoInterface": errors.VCI_E_NOINTERFACE,
    "VciNoMoreItems": errors.VCI_E_NO_MORE_ITEMS,
    "VciNoSuchDevice": errors.VCI_E_NO_SUCH_DEVICE,
    "VciNotImplemented": errors.VCI_E_NOT_IMPLEMENTED,
    "VciNotInitialized": errors.VCI_E_NOT_INITIALIZED,
    "VciNotSupported": errors.VCI_E_NOT_SUPPORTED,
    "VciRxQueueEmpty": errors.VCI_E_RXQUEUE_EMPTY,
    "VciTimeout": errors.VCI_E_TIMEOUT,
    "VciTxQueueFull": errors.VCI_E_TXQUEUE_FULL,
}


@pytest.mark.conforms("X4-01")
@each(("name", "code"), NUMBERED + SPOT_CHECKS)
def test_codes_and_their_text(name: str, code: int) -> None:
    assert getattr(errors, name) == code
    assert format_error(code) == format_error(code - 2**32)
    assert format_error(code).startswith(f"{name} (0x{code:08X}): ")
    assert len(format_error(code)) < errors.VCI_MAX_ERRSTRLEN


def test_there_are_no_other_codes() -> None:
    assert {name for name in vars(errors) if name.startswith("VCI_E_")} == {name for name, _ in NUMBERED}


def test_each_text_is_its_own() -> None:
    texts = {format_error(code).partition("): ")[2] for _, code in NUMBERED}
    assert len(texts) == len(NUMBERED)


def test_severities() -> None:
    assert (errors.SEV_VCI_INFO, errors.SEV_VCI_WARN, errors.SEV_VCI_ERROR, errors.FACILITY_VCI) == (
        0x60010000,
        0xA0010000,
        0xE0010000,
        1,
    )
    assert errors.VCI_OK == errors.VCI_SUCCESS == 0
    assert format_error(errors.VCI_OK) == "VCI_OK (0x00000000): success"


@pytest.mark.conforms("X4-01")
@given(st.integers(-(2**31), 2**32 - 1))
def test_any_32_bit_number_has_a_text(code: int) -> None:
    text = format_error(code)
    assert 0 < len(text) < errors.VCI_MAX_ERRSTRLEN
    assert f"0x{code & 0xFFFFFFFF:08X}" in text


def test_unknown_codes_are_taken_apart() -> None:
    assert format_error(0xE0010099) == "0xE0010099: unknown result code (error 153 of facility 1)"
    assert format_error(0x60010001) == "0x60010001: unknown result code (information 1 of facility 1)"


@each("code", [2**32, -(2**31) - 1, 1.5, "VCI_OK", None])
def test_no_32_bit_number(code: int) -> None:
    with pytest.raises(VciInvalidArgument, match="32-bit") as caught:
        format_error(code)
    assert caught.value.code == errors.VCI_E_INVALIDARG
    with pytest.raises(VciInvalidArgument):
        VciError(code)


@each("name", SUBCLASSES)
def test_subclasses_by_code(name: str) -> None:
    code = SUBCLASSES[name]
    kind = getattr(errors, name)
    for error in (VciError(code, "why"), VciError.of(code, "why"), VciError(code - 2**32, "why")):
        assert type(error) is kind
        assert error.code == code
        assert error.hresult == code - 2**32
        assert error.what == "why"


def test_no_subclass_is_missing_above() -> None:
    own = {kind.__name__ for kind in VciError.__subclasses__() if kind.__module__ == errors.__name__}
    assert own == set(SUBCLASSES)  # v3 has more


def test_an_error_says_name_number_meaning_and_why() -> None:
    with pytest.raises(VciTimeout) as caught:
        raise VciError(errors.VCI_E_TIMEOUT, "detect_baud: 5000 ms of silence")
    assert (
        str(caught.value) == "VCI_E_TIMEOUT (0xE001000B): the time ran out; detect_baud: 5000 ms of silence"
    )
    assert isinstance(caught.value, CanwireError)


def test_codes_without_a_subclass() -> None:
    error = VciError(errors.VCI_E_WRONG_LEVEL)
    assert type(error) is VciError
    assert str(error) == format_error(errors.VCI_E_WRONG_LEVEL)
    assert VciError(0x60010001).hresult == 0x60010001


@pytest.mark.parametrize("again", [copy.copy, lambda error: pickle.loads(pickle.dumps(error))])
def test_errors_travel(again: object) -> None:
    assert callable(again)
    error = again(VciError(errors.VCI_E_TIMEOUT, "here"))
    assert type(error) is VciTimeout
    assert (error.code, error.what, str(error)) == (
        errors.VCI_E_TIMEOUT,
        "here",
        str(VciError(errors.VCI_E_TIMEOUT, "here")),
    )
