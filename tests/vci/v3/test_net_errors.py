"""Exceptions: V4's and canwire's come out as .NET's."""

from __future__ import annotations

import pickle

import pytest

import canwire
from canwire import vci
from canwire.vci import v3
from canwire.vci.v3.errors import as_exception, exceptions
from tests.cases import each

KINDS = [
    (vci.VCI_E_INVALIDARG, v3.ArgumentException),
    (vci.VCI_E_INVALID_INDEX, v3.ArgumentOutOfRangeException),
    (vci.VCI_E_NOT_IMPLEMENTED, v3.NotImplementedException),
    (vci.VCI_E_NOINTERFACE, v3.NotImplementedException),
    (vci.VCI_E_INVHANDLE, v3.ObjectDisposedException),
    (vci.VCI_E_ACCESSDENIED, v3.VciException),
    (vci.VCI_E_TIMEOUT, v3.VciException),
]


@each(("code", "kind"), KINDS)
def test_codes_become_exceptions(code: int, kind: type[vci.VciError]) -> None:
    error = as_exception(vci.VciError.of(code, "because"))
    assert type(error) is kind
    assert (error.code, error.what) == (code, "because")


def test_errors_of_canwire_become_exceptions() -> None:
    with pytest.raises(v3.VciException) as raised, exceptions():
        raise canwire.Unplugged("gone")
    assert raised.value.code == vci.VCI_E_DEVICE_NOT_CONNECTED


def test_exceptions_of_v3_stay_as_they_are() -> None:
    error = v3.ObjectDisposedException(vci.VCI_E_NOT_INITIALIZED, "not yet")
    with pytest.raises(v3.ObjectDisposedException) as raised, exceptions():
        raise error
    assert raised.value is error


@each(
    ("kind", "builtin"),
    [
        (v3.ArgumentException, ValueError),
        (v3.ArgumentOutOfRangeException, IndexError),
        (v3.NotImplementedException, NotImplementedError),
    ],
)
def test_some_are_exceptions_of_python_too(kind: type[vci.VciError], builtin: type[Exception]) -> None:
    assert issubclass(kind, builtin)


def test_busy_and_absent_are_told_apart() -> None:
    assert not issubclass(v3.NotImplementedException, v3.VciException)
    assert issubclass(v3.NotImplementedException, vci.VciError)
    assert issubclass(v3.ObjectDisposedException, vci.VciError)


def test_they_can_be_pickled() -> None:
    error = pickle.loads(pickle.dumps(v3.ArgumentOutOfRangeException(vci.VCI_E_INVALIDARG, "far out")))
    assert type(error) is v3.ArgumentOutOfRangeException
    assert error.what == "far out"


def test_the_server_has_the_texts() -> None:
    assert v3.VciServer.get_error_msg(vci.VCI_E_TIMEOUT) == vci.format_error(vci.VCI_E_TIMEOUT)
    with pytest.raises(v3.ArgumentException):
        v3.VciServer.get_error_msg(1 << 40)
