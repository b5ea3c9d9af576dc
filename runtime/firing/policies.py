"""Policies after a failed firing: the marking is unchanged; the policy decides how the node continues."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Halt:
    """The node stops firing until `proceed` is called; tokens and signals still arrive."""

    name = "halt"


@dataclass(frozen=True)
class Aside:
    """The tokens stay in their places, and this transition does not take them until `release`."""

    name = "aside"


@dataclass(frozen=True)
class Retry:
    """The transition is retried after a delay, which grows with each attempt.

    Parameters
    ----------
    attempts : int
        Maximum number of attempts with the same tokens.
    delay : float
        Seconds before the second attempt.
    factor : float
        Factor by which the delay grows with each attempt.
    longest : float
        The longest delay, in seconds.
    then : Halt or Aside
        Policy after the last attempt has failed.
    """

    attempts: int = 3
    delay: float = 0.1
    factor: float = 2.0
    longest: float = 30.0
    then: Halt | Aside = Halt()

    name = "retry"

    def __post_init__(self) -> None:
        if self.attempts < 1 or self.delay < 0 or self.factor < 1 or self.longest < 0:
            raise ValueError(f"no policy: {self!r}")

    def delay_after(self, attempt: int) -> float:
        """Return the delay in seconds after an attempt; attempts count from 1."""
        return float(min(self.longest, self.delay * self.factor ** (attempt - 1)))


Policy = Halt | Retry | Aside
