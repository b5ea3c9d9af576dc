"""Records which code the programs of a folder reach; other code is read separately or reported."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(eq=False)
class Reached:
    """Classes and calls that programs have reached so far."""

    classes: set[int] = field(default_factory=set)
    """Classes of the nodes that a program made, by ``id``."""
    calls: set[tuple[str, int]] = field(default_factory=set)
    """Path and line of the calls that make entities and that a program came to."""
