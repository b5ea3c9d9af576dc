"""Models that break exactly one constraint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.support.broken.small import Small, system

Break = Callable[[Small], object]


@dataclass(frozen=True)
class Case:
    """How to break a valid model, and what is then said."""

    constraint: str
    message: str
    fix: str
    make: Callable[[], Small]
    break_: Break

    def __str__(self) -> str:
        return f"{self.constraint}-{self.break_.__name__}"


class Cases(list[Case]):
    """The cases of one family of constraints; `breaks` adds one."""

    def breaks(
        self, constraint: str, message: str, fix: str, of: Callable[[], Small] = system
    ) -> Callable[[Break], Break]:
        """Register a function that breaks one constraint of a valid model."""

        def register(break_: Break) -> Break:
            self.append(Case(constraint, message, fix, of, break_))
            return break_

        return register
