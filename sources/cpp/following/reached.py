"""What the programs of a folder have reached: what none did is read by itself, or named."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(eq=False)
class Reached:
    """What programs reached so far.

    Attributes
    ----------
    classes : set of int
        Classes of the nodes that a program made, by ``id``.
    calls : set of (str, int)
        Path and line of the calls that make entities and that a program came to.
    """

    classes: set[int] = field(default_factory=set)
    calls: set[tuple[str, int]] = field(default_factory=set)
