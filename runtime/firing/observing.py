"""Who is told what happens in a net, and how errors are told."""

from __future__ import annotations

from typing import Protocol

from dineros.metamodel.errors import DinerosError


class FiringObserver(Protocol):
    """Told what happens.

    Attributes
    ----------
    is_observing : bool
        Whether anybody wants to know; if not, nothing is put together for it.
    """

    is_observing: bool

    def emit(self, event: str, **fields: object) -> None:
        """Tell of an event, when it has happened."""

    def tell_error(
        self,
        error: str,
        policy: str | None = None,
        *,
        transition: str | None = None,
        handler: str | None = None,
        attempt: int = 1,
    ) -> None:
        """Tell of an error, what is done about it, where it was, and for the how many-th time."""

    def status_changed(self) -> None:
        """Learn that the node is not as it was: it runs, is halted, or is blocked."""


def shown(error: BaseException) -> str:
    """Return an exception as one line; a wrong return speaks for itself."""
    text = " ".join(str(error).split())
    if isinstance(error, DinerosError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
