"""canwire's errors come out as VCI's result codes."""

from __future__ import annotations

import inspect

import pytest

import canwire
from canwire import errors, vci
from canwire.vci.translation import CODES, as_vci_error, meaning, translated
from tests.cases import each

EVERY = [
    kind
    for _, kind in inspect.getmembers(errors, inspect.isclass)
    if issubclass(kind, errors.CanwireError) and kind is not errors.CanwireError
]


def made(kind: type[errors.CanwireError]) -> errors.CanwireError:
    """An error of this kind, whatever its constructor wants."""
    error = kind.__new__(kind)
    Exception.__init__(error, "who and why")
    return error


@pytest.mark.conforms("X4-01")
@each("kind", EVERY)
def test_every_error_has_a_code_of_its_own_family(kind: type[errors.CanwireError]) -> None:
    nearest = next(ancestor for ancestor in kind.__mro__ if ancestor in CODES)
    assert nearest is not errors.CanwireError


@each("kind", [kind for kind in EVERY if hasattr(canwire, kind.__name__)])
def test_every_public_error_stands_in_the_table(kind: type[errors.CanwireError]) -> None:
    assert kind in CODES


@pytest.mark.conforms("X4-01")
@each(
    ("kind", "code"),
    [
        (canwire.InUse, "ACCESSDENIED"),
        (canwire.NotInitialised, "NOT_INITIALIZED"),
        (canwire.WrongState, "INVALID_STATE"),
        (canwire.Unsupported, "NOT_SUPPORTED"),
        (canwire.NothingHeard, "TIMEOUT"),
        (canwire.HubLost, "DISCONNECTED"),
        (canwire.Unplugged, "DEVICE_NOT_CONNECTED"),
        (canwire.NoSuchBoard, "NO_SUCH_DEVICE"),
        (canwire.QueueFull, "TXQUEUE_FULL"),
        (canwire.Busy, "BUSY"),
        (canwire.BadTiming, "INVALID_TIMING"),
        (canwire.BadFilter, "INVALIDARG"),
        (canwire.Closed, "INVHANDLE"),
        (canwire.CanwireError, "FAIL"),
    ],
)
def test_codes(kind: type[errors.CanwireError], code: str) -> None:
    error = as_vci_error(made(kind))
    assert error.code == getattr(vci, f"VCI_E_{code}")
    assert "who and why" in str(error)


def test_a_block_translates_and_keeps_the_cause() -> None:
    cause = canwire.InUse("engine's control is held by tester")
    with pytest.raises(vci.VciAccessDenied, match="held by tester") as raised, translated():
        raise cause
    assert raised.value.__cause__ is cause


def test_what_is_translated_already_passes() -> None:
    error = vci.VciError.of(vci.VCI_E_BUSY, "somebody")
    with pytest.raises(vci.VciBusy) as raised, translated():
        raise error
    assert raised.value is error


def test_a_function_may_mean_something_else() -> None:
    with pytest.raises(vci.VciNotImplemented), meaning(vci.VCI_E_NOT_IMPLEMENTED, canwire.Unsupported):
        raise canwire.Unsupported("no list")
    with pytest.raises(canwire.InUse), meaning(vci.VCI_E_NOT_IMPLEMENTED, canwire.Unsupported):
        raise canwire.InUse("held")


def test_errors_that_are_not_canwires_stay_what_they_are() -> None:
    with pytest.raises(ZeroDivisionError), translated():
        raise ZeroDivisionError
