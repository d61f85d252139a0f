"""The beginning and the end of a company of threads."""

from __future__ import annotations

import threading
from typing import Protocol

from canwire.threads.company import Company
from canwire.threads.keeper import Keeper
from canwire.threads.member import current
from canwire.threads.replaced import REPLACED


class HasCompany(Protocol):
    """A hub or a lab."""

    company: Company | None


class TakesPart(HasCompany, Protocol):
    """A connection to a hub."""

    def keeper(self) -> Keeper | None: ...


def begin(hub: HasCompany, keeper: Keeper) -> Company:
    """Let threads take turns from now on, until `end`."""
    REPLACED.begin()
    company = hub.company = Company(keeper)
    company.when_over = REPLACED.end
    return company


def end(hub: HasCompany, company: Company) -> None:
    """End the turns: threads that wait continue in real time."""
    company.dissolve()
    hub.company = None


def own_company() -> Company | None:
    """Return the company of the calling thread, or None."""
    me = current()
    return me.company if me is not None and isinstance(me.company, Company) else None


def take_turns(hub: TakesPart) -> None:
    """Let the threads take turns until the program's end, if it shares one time with other programs."""
    keeper, company = hub.keeper(), own_company()
    if keeper is None or hub.company is not None:
        return
    if company is not None:
        company.go_on_at(keeper)
        hub.company = company
        return
    company = begin(hub, keeper)
    threading._threading_atexits.insert(0, company.last_words)  # type: ignore[attr-defined]  # the last of them
