"""Properties of a net as in the Model Checking Contest, and their answers.

References
----------
F. Kordon et al., *MCC'2022: 12th edition of the Model Checking Contest*, https://mcc.lip6.fr.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from dineros.analysis.answers.evidence import Evidence
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import (
    And,
    Comparison,
    Constant,
    Deadlock,
    Enabled,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Name,
    Or,
)
from dineros.analysis.nets.compiled import CompiledNet

Kind = Literal["ctl", "ltl", "bound", "global"]

GLOBAL_PROPERTIES = ("ReachabilityDeadlock", "OneSafe", "QuasiLiveness", "Liveness", "StableMarking")
"""Questions about any net, by their names in the contest."""

_SHOWN = (
    "structure",
    "state equation",
    "initial marking",
    "random walk",
    "directed walk",
    "explicit, from a random walk",
)


@dataclass(frozen=True)
class Property:
    """One question about a net.

    Attributes
    ----------
    kind : {"ctl", "ltl", "bound", "global"}
        Kind of the question: a CTL or LTL formula, the most tokens that places have together, or one of
        `GLOBAL_PROPERTIES`.
    formula : Formula, optional
        For "ctl" and "ltl", with this project's semantics: a run stays in a deadlock forever.
    places : tuple of str
        For "bound": names of places, whose tokens are added.
    """

    id: str
    kind: Kind
    formula: Formula | None = None
    places: tuple[str, ...] = ()
    examination: str = ""


@dataclass(frozen=True)
class PropertyAnswer:
    """The answer to a property.

    Attributes
    ----------
    id : str
    value : bool, int or None
        Whether it holds, or the bound; None: unknown.
    seconds : float
        Wall-clock time from the start of all questions asked together.
    technique : str
        The deciding technique: ``structure``, ``state equation``, ``random walk``, ``explicit``, ``symbolic``
        ...
    evidence : Evidence or None
        The evidence, if it is structural or inductive.
    dead : str
        If a net is not quasi-live by structure: the name of a transition that never fires.
    """

    id: str
    value: bool | int | None
    seconds: float
    technique: str = ""
    reason: str = ""
    evidence: Evidence | None = None
    dead: str = ""

    @property
    def rests_on_markings(self) -> bool:
        """Whether neither a run nor a structural or inductive proof shows it."""
        return self.value is not None and self.evidence is None and self.technique not in _SHOWN


def said_of_all(examination: str, net: CompiledNet) -> Formula:
    """Return a question about any net as a formula; `recognised` is the inverse."""
    fired = [Enabled(Name(transition)) for transition in net.transitions]
    places = [Name(place) for place in net.places]
    match examination:
        case "ReachabilityDeadlock":
            return Exists(Finally(Deadlock()))
        case "OneSafe":
            return ForAll(Globally(_joined(And, [Comparison(((1, p),), "<=", 1) for p in places])))
        case "QuasiLiveness":
            return _joined(And, [Exists(Finally(each)) for each in fired])
        case "Liveness":
            return _joined(And, [ForAll(Globally(Exists(Finally(each)))) for each in fired])
        case _:  # a stable marking
            tokens = zip(places, net.initial.tolist(), strict=True)
            return _joined(Or, [ForAll(Globally(_equal(p, held))) for p, held in tokens])


def _equal(place: Name, tokens: int) -> Formula:
    """Return that a place holds this number, with the only comparison that the contest has."""
    return And((Comparison(((1, place),), "<=", tokens), Comparison(((-1, place),), "<=", -tokens)))


def recognised(one: Property, net: CompiledNet) -> Property:
    """Return a question about any net if the formula is that question; otherwise the property itself.

    The id alone does not decide: ``Robot-Liveness`` may be any formula.
    """
    for examination in GLOBAL_PROPERTIES[1:]:  # a deadlock is a formula of the contest's own
        if f"-{one.id}".endswith(f"-{examination}") and one.formula == said_of_all(examination, net):
            return Property(one.id, "global", examination=examination)
    return one


def _joined(operator: type[And | Or], parts: list[Formula]) -> Formula:
    """Return a formula of any number of parts."""
    if len(parts) > 1:
        return operator(tuple(parts))
    return parts[0] if parts else Constant(operator is And)


class GroupedNames:
    """Names of a net, and of sets of its transitions: ``is-fireable`` means that any of a set is enabled."""

    SEPARATOR = " or "

    def __init__(self, names: Names) -> None:
        self._names = names
        self._groups: dict[str, tuple[str, ...]] = {}

    def group(self, names: Sequence[str]) -> str:
        """Return a name for a set of transitions."""
        text = self.SEPARATOR.join(names)
        if len(names) > 1:
            self._groups[text] = tuple(names)
        return text

    def members(self, name: str) -> tuple[str, ...]:
        """Return the names in a group, or the name itself."""
        return self._groups.get(name, (name,))

    def ungrouped(self, formula: Formula) -> Formula:
        """Return a formula without groups, as a disjunction over their transitions."""

        def single(part: Formula) -> Formula | None:
            members = self.members(part.name.text) if isinstance(part, Enabled) else ()
            return Or(tuple(Enabled(Name(member)) for member in members)) if len(members) > 1 else None

        return formula.replaced(single)

    def places(self, name: str) -> Sequence[int]:
        """Return the places of a name."""
        return self._names.places(name)

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions of a name or of a group."""
        return [t for member in self.members(name) for t in self._names.transitions(member)]

    def signal(self, name: str) -> int:
        """Return the place that is marked while an input signal is true."""
        return self._names.signal(name)
