"""Access rights: the file with the users of a hub, the file with the login of a program, and the right per request."""

from __future__ import annotations

import os
import tomllib
from typing import Annotated, Literal, TypeVar

import msgspec
from msgspec import Meta

from canwire.errors import BadConfig, HubError
from canwire.hub.links.network.keys import ANYBODY
from canwire.hub.protocol import messages as m

LISTEN, SEND, CONFIGURE = "listen", "send", "configure"
_RIGHTS = (LISTEN, SEND, CONFIGURE)
Name = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_.-]{1,64}$")]
Word = Annotated[str, Meta(pattern=r"^[^:\n]*$")]  # as Zenoh's dictionary of passwords takes it
File = TypeVar("File", "Access", "Login")


class Tls(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[tls]: PEM files. The authority `ca` has signed this end's certificate and the other's."""

    ca: str
    certificate: str
    key: str


class User(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[users.NAME]: a user without a password is identified by the name in the certificate."""

    may: Literal["listen", "send", "configure"]
    password: Word = ""


class Router(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[router]: the login of a hub at routers (`--via`); without a password, its certificate counts."""

    user: Name
    password: Word = ""


class Access(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A hub's file (`canwire serve --access`): the rights of each user; others have no access."""

    users: dict[Name, User]
    tls: Tls | None = None
    router: Router | None = None

    def __post_init__(self) -> None:
        known = self.users | ({self.router.user: self.router} if self.router is not None else {})
        without = [name for name, user in known.items() if not user.password]
        if without and self.tls is None:
            raise ValueError(f"{', '.join(without)}: each user needs a password where there is no [tls]")
        if 0 < len(without) < len(known):
            raise ValueError(
                f"{', '.join(without)} without a password beside others who have one: Zenoh lets in either all by "
                "password or all by certificate; keep two files, and offer the hub twice (`canwire offer`)"
            )
        if self.router is not None and self.router.user in self.users:
            raise ValueError(f"{self.router.user} is the hub's own name in [router], and cannot be a user's")


class Login(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A program's file (CANWIRE_NETWORK)."""

    user: Name = ANYBODY
    password: Word = ""
    tls: Tls | None = None


def load(kind: type[File], path: str) -> File:
    """The contents of the file; paths in it are relative to its directory. Raises BadConfig."""
    try:
        with open(path, "rb") as file:
            found = msgspec.convert(tomllib.load(file), kind, strict=True)
    except OSError as error:
        raise BadConfig(f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:  # msgspec's and tomllib's are ValueErrors, too
        raise BadConfig(f"{path}: {error}") from None
    if found.tls is None:
        return found
    here = os.path.dirname(os.path.abspath(path))
    tls = Tls(
        **{name: os.path.join(here, value) for name, value in msgspec.structs.asdict(found.tls).items()}
    )
    return msgspec.structs.replace(found, tls=tls)


def usual_login() -> Login:
    """The login in the file that CANWIRE_NETWORK names; an anonymous one without such a file."""
    path = os.environ.get("CANWIRE_NETWORK")
    return load(Login, path) if path else Login()


_LISTENING = (
    m.Hello, m.ListBoards, m.Watch, m.OpenChannel, m.OpenMonitor, m.Close, m.GetLineStatus, m.GetLinStatus,
    m.GetLineStatuses, m.GetLinStatuses,
    m.GetFilterMode, m.SetFilterMode, m.SetAcceptanceFilter, m.ListIds, m.ReplaceFilters, m.SetUpChannel,
    m.SetUpMonitor, m.Activate, m.GetChannelStatus, m.GetMonitorStatus, m.Advance, m.Sleep, m.GetRegisters,
    m.GetNote, m.ListNotes, m.GetBus, m.GetFault, m.AwaitFault, m.ListFaults, m.GetTime,
)  # fmt: skip
_SENDING = (
    m.JoinTime, m.AwaitTurn, m.LeaveTime, m.Stir,  # who takes part holds everybody up
    m.CancelQueued, m.PassOn, m.CountRefused, m.CreateFifo, m.OpenFifo, m.ResetFifo, m.CreateLuid, m.OpenScheduler,
    m.AddCyclic, m.RemoveCyclic, m.StartCyclic, m.StopCyclic, m.RunScheduler, m.ResetScheduler, m.GetSchedulerStatus,
    m.ReplaceCyclic, m.StartInTurn, m.OpenShare, m.OpenLayer,
)  # fmt: skip


def needed(request: m.Message) -> str:
    """The right that a request needs. Exclusive use of a line needs more than `listen` or `send`."""
    if isinstance(request, (m.OpenChannel, m.OpenMonitor)) and request.exclusive:
        return CONFIGURE
    if isinstance(request, m.SetUpChannel):
        return SEND if request.mode.transmit else LISTEN
    if isinstance(request, _LISTENING):
        return LISTEN
    return SEND if isinstance(request, _SENDING) else CONFIGURE


def check(user: str, may: str, request: m.Message) -> None:
    """Raises HubError if this user has no right to the request."""
    right = needed(request)
    if _RIGHTS.index(right) > _RIGHTS.index(may):
        raise HubError(
            f"{type(request).__name__} needs the right to {right} on this hub, {user} may only {may}: "
            f"the file of `canwire serve --access` says so"
        )


def right_of(access: Access | None, user: str) -> str | None:
    """The right of a user; None for an unknown user."""
    if access is None:
        return CONFIGURE
    found = access.users.get(user)
    return None if found is None else found.may
