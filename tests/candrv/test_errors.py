"""Every error of canwire has a Win32 code. Source: rulings.md 20; CANDRV manual, 7.8."""

from __future__ import annotations

import inspect
import pickle

import pytest

import canwire
from canwire import errors
from canwire.candrv import CandrvError, Win32Error, format_error
from canwire.candrv.errors import CODES, TEXTS, as_candrv, translated, win32_code

EVERY = {
    name: error
    for name, error in vars(errors).items()
    if inspect.isclass(error) and issubclass(error, errors.CanwireError)
}


def made(error: type[errors.CanwireError]) -> errors.CanwireError:
    """One of them, whatever it wants to be told."""
    one = error.__new__(error)
    Exception.__init__(one, "this is why")
    return one


@pytest.mark.conforms("FS-13")
def test_the_table_is_complete() -> None:
    assert len(EVERY) > 20
    assert set(EVERY) == set(CODES)


@pytest.mark.parametrize("name", sorted(EVERY))
def test_each_goes_as_its_own_code_in_its_own_words(name: str) -> None:
    error = as_candrv(made(EVERY[name]))
    assert error.code == CODES[name] == win32_code(error)
    assert "this is why" in str(error)


# what the manual and the ruling imply
@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("BadValue", 87),
        ("BadText", 87),
        ("BadTiming", 87),
        ("QueueFull", 1460),
        ("NotTransmitted", 995),
        ("NoChannel", 1450),
        ("Unsupported", 50),
        ("NoSuchBoard", 2),
        ("InUse", 32),
        ("Closed", 6),
        ("NothingHeard", 1460),
    ],
)
def test_codes(name: str, code: int) -> None:
    assert CODES[name] == code


def test_what_is_derived_goes_as_what_it_is_derived_from() -> None:
    class BadColour(errors.BadFilter):
        pass

    assert win32_code(BadColour("red")) == 87


def test_every_code_has_a_text() -> None:
    assert set(TEXTS) == set(Win32Error)
    assert len(set(TEXTS.values())) == len(TEXTS)


def test_message() -> None:
    error = CandrvError(1460, "CID1: ReadFile, nothing in 300 ms")
    assert str(error) == "ERROR_TIMEOUT (1460), the time ran out: CID1: ReadFile, nothing in 300 ms"
    assert (error.code, error.name, error.what) == (
        1460,
        "ERROR_TIMEOUT",
        "CID1: ReadFile, nothing in 300 ms",
    )
    assert isinstance(error, canwire.CanwireError)
    assert (
        str(CandrvError(5))
        == format_error(5)
        == "ERROR_ACCESS_DENIED (5), the handle was not opened with the access that the call needs"
    )
    assert str(CandrvError(4711, "who knows")) == "error 4711: who knows"
    assert CandrvError(4711).name == "4711"


def test_errors_travel_between_processes() -> None:
    error = pickle.loads(pickle.dumps(CandrvError(87, "why")))
    assert (type(error), error.code, str(error)) == (CandrvError, 87, str(CandrvError(87, "why")))


def test_translated() -> None:
    with pytest.raises(CandrvError, match=r"ERROR_INVALID_HANDLE.*port is closed") as caught, translated():
        raise canwire.Closed("port")
    assert isinstance(caught.value.__cause__, canwire.Closed)
    own = CandrvError(995)
    with pytest.raises(CandrvError) as again, translated():
        raise own
    assert again.value is own
    with pytest.raises(KeyError), translated():
        raise KeyError
