"""A search for adapters that finds none says whether a library was missing."""

from __future__ import annotations

from collections.abc import Set

import pytest

from canwire.boards import adapters
from canwire.errors import ExtraMissing
from tests.cases import each


def installed(monkeypatch: pytest.MonkeyPatch, libraries: Set[str]) -> None:
    """A machine with these libraries and no adapters."""
    monkeypatch.setattr(adapters, "find_spec", lambda name: object() if name in libraries else None)
    monkeypatch.setattr(adapters, "described_ports", list)
    monkeypatch.setattr(adapters.devices, "find_devices", list)
    monkeypatch.setattr(adapters, "known_interfaces", list)
    monkeypatch.setattr(adapters, "detected_configs", list)


@each("libraries", [{"serial"}, {"can"}, {"serial", "can"}])
def test_with_a_library_no_adapter_is_an_empty_list(
    monkeypatch: pytest.MonkeyPatch, libraries: set[str]
) -> None:
    installed(monkeypatch, libraries)
    assert adapters.find_adapters() == []


def test_without_any_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    installed(monkeypatch, set())
    with pytest.raises(ExtraMissing, match=r"canwire\[hardware\]"):
        adapters.find_adapters()
