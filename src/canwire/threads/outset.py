"""The beginning and the end of a company of threads."""

from __future__ import annotations

from typing import Protocol

from canwire.threads.company import Company
from canwire.threads.keeper import Keeper
from canwire.threads.replaced import REPLACED


class HasCompany(Protocol):
    """A hub or a lab."""

    company: Company | None


def begin(hub: HasCompany, keeper: Keeper) -> Company:
    """From now on, until `end`."""
    REPLACED.begin()
    company = hub.company = Company(keeper)
    return company


def end(hub: HasCompany, company: Company) -> None:
    """Whoever waits goes on by the clock."""
    hub.company = None
    company.dissolve()
    REPLACED.end()
