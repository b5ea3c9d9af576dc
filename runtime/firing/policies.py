"""What becomes of a firing that failed: the marking is as it was before; these say how the node continues."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Halt:
    """The node fires nothing more until somebody calls `proceed`; tokens and signals still arrive."""

    name = "halt"


@dataclass(frozen=True)
class Aside:
    """The tokens stay in their places, and this transition leaves them alone until `release`."""

    name = "aside"


@dataclass(frozen=True)
class Retry:
    """The transition is tried again later, each time later still.

    Parameters
    ----------
    attempts : int
        How often in all, with the same tokens.
    delay : float
        Seconds before the second attempt.
    factor : float
        By how much the delay grows with each attempt.
    longest : float
        The longest delay, in seconds.
    then : Halt or Aside
        What happens when the last attempt has failed.
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
        """Return the seconds to wait after an attempt, counted from 1."""
        return float(min(self.longest, self.delay * self.factor ** (attempt - 1)))


Policy = Halt | Retry | Aside
