"""What is analysed: a model compiled to a net, with the words of the model for elements of the net."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, get_args

from dineros.analysis.model.names import ModelNames, PlainNames, unique_names
from dineros.analysis.model.wording import words
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.metamodel.guards.using import require_no_guards
from dineros.transformations.flattening.bounding import bounded

if TYPE_CHECKING:
    from dineros.transformations.flattening.flatten import Flattened
    from dineros.transformations.flattening.traces import Link
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant

# A plain net needs no rules of flattening, which are imported where a system model asks for them.


@dataclass(frozen=True)
class FiringTime:
    """When a transition of a firing sequence fires, in the unit of the model's intervals.

    Attributes
    ----------
    at : float
        In the schedule that is shown.
    earliest, latest : float, float or None
        In all schedules of the sequence; None: it may be any time later.
    """

    at: float
    earliest: float
    latest: float | None

    def __str__(self) -> str:
        latest = "any time later" if self.latest is None else f"{self.latest:g}"
        only = self.earliest == self.latest
        return f"at {self.at:g}" + ("" if only else f" (from {self.earliest:g} to {latest})")


@dataclass(frozen=True)
class Subject:
    """A net under analysis.

    Attributes
    ----------
    model : pn.Net
        The model it comes from: a system model, or the net itself.
    flattened : Flattened or None
        How a system model became the net; None for a plain net.
    blocked : tuple of str
        Ids of the transitions that were left out, since their clause can never be true: they never fire.
    """

    model: pn.Net
    net: CompiledNet
    flattened: Flattened | None = None
    blocked: tuple[str, ...] = ()

    @property
    def is_timed(self) -> bool:
        """Whether runs need a schedule."""
        return False

    @cached_property
    def place_index(self) -> dict[str, int]:
        """Index of each place, by its id in the net."""
        return {name: index for index, name in enumerate(self.net.places)}

    @cached_property
    def transition_index(self) -> dict[str, int]:
        """Index of each transition, by its id in the net."""
        return {name: index for index, name in enumerate(self.net.transitions)}

    @cached_property
    def names(self) -> ModelNames | PlainNames:
        """Names of the model, for formulas and goals."""
        if self.flattened is None:
            return PlainNames(self.net, self.model)
        return ModelNames(self.net, self.links())

    @cached_property
    def _shown(self) -> dict[str, str]:
        """The names of the nodes of a plain net, by their ids, if a name is unique."""
        return unique_names(self.model) if self.flattened is None else {}

    def times_of(self, trace: Sequence[int]) -> Sequence[FiringTime | None]:
        """Return by firing of a sequence when it happens; None for each of a net without times."""
        return [None] * len(trace)

    def links(self) -> list[Link]:
        """Return how each element of the net was made; empty for a plain net."""
        return [] if self.flattened is None else self.flattened.trace.links

    @cached_property
    def _by_id(self) -> dict[str, Link]:
        return {link.target.id: link for link in self.links() if not isinstance(link.target, pn.Arc)}

    def link_of(self, name: str) -> Link | None:
        """Return how a place or transition of the net was made; None in a plain net."""
        return self._by_id.get(name)

    def place_text(self, index: int) -> str:
        """Return a place in the words of the model."""
        name = self.net.places[index]
        return words(self._by_id[name]) if name in self._by_id else self._shown.get(name, name)

    def transition_text(self, index: int) -> str:
        """Return what firing a transition means, in the words of the model."""
        name = self.net.transitions[index]
        return words(self._by_id[name]) if name in self._by_id else self._shown.get(name, name)

    def transition_element(self, index: int) -> str:
        """Return the id of the element of the model that a transition is, or that it was made for."""
        name = self.net.transitions[index]
        link = self._by_id.get(name)
        return name if link is None or not link.sources else str(getattr(link.sources[0], "id", None) or name)


def subject_of(
    model: pn.Net,
    signals: SignalVariant = "input-enabled",
    overflow: OverflowVariant = "weighted",
) -> Subject:
    """Flatten a system model, and compile it; compile any other net."""
    if isinstance(model, sym.SystemModel):
        from dineros.transformations.flattening.flatten import flatten

        flattened = flatten(model, signals, overflow)
        return Subject(model, compile_net(flattened.net), flattened)
    if isinstance(model, rtm.RuntimeModel):
        require_no_guards(model, "the analysis of a single node")
    return Subject(model, compile_net(bounded(model)))


def subject_for(model: pn.Net, signals: str, overflow: str = "weighted") -> Subject:
    """Flatten and compile with variants given by name, as in traces and pages.

    Without signals, transitions that a clause blocks forever are not part of the net, as in `base_subject`.

    Raises
    ------
    UnknownElementError
        There is no such variant.
    """
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant

    for what, found, variants in (
        ("signals", signals, SignalVariant),
        ("overflow", overflow, OverflowVariant),
    ):
        known = get_args(variants)
        if found not in known:
            hint = near_matches(found, known) or f"there are {', '.join(known)}"
            raise UnknownElementError(f"there is no variant {found!r} of {what}", hint=hint)
    if signals == "none":
        return base_subject(model, overflow)  # type: ignore[arg-type]
    return subject_of(model, signals, overflow)  # type: ignore[arg-type]


def base_subject(model: pn.Net, overflow: OverflowVariant = "weighted") -> Subject:
    """Compile the net without signals and without the transitions whose clause can never be true.

    With fully-enabled signals, a marking of the other places, or the enabling of a transition of the system
    model, is reachable if and only if it is in this net: a signal can always change, so a satisfiable clause
    never blocks forever, and changes of signals change nothing else.
    """
    if not isinstance(model, sym.SystemModel):
        return subject_of(model)
    flattened, blocked = flattened_without_signals(model, overflow)
    return Subject(model, compile_net(flattened.net), flattened, blocked)


def _is_of(link: Link, transitions: Sequence[EObject]) -> bool:
    """Whether what was made is one of some transitions, or, with times, begins or replaces one."""
    from dineros.transformations.rules.starts import D2Start
    from dineros.transformations.rules.times.work import D3

    if link.maker is None:
        return link.role == "transition" and link.sources[0] in transitions
    return link.maker in (D2Start, D3) and any(each in transitions for each in link.sources)


def flattened_without_signals(
    model: sym.SystemModel, overflow: OverflowVariant = "weighted", times: bool = False
) -> tuple[Flattened, tuple[str, ...]]:
    """Flatten a system model without signals and without transitions whose clause can never be true.

    With `times`, the rules about times run, too.

    Returns
    -------
    flattened : Flattened
    blocked : tuple of str
        Ids of the transitions that were left out.
    """
    from dineros.analysis.model.satisfiability import unsatisfiable_clauses
    from dineros.transformations.flattening.flatten import Flattened, flatten
    from dineros.transformations.flattening.traces import Trace

    blocked = [found.transition for found in unsatisfiable_clauses(model)]
    flattened = flatten(model, "none", overflow, times=times)
    if not blocked:
        return flattened, ()
    gone: set[pn.Element] = {
        link.target
        for link in flattened.trace.links
        if isinstance(link.target, pn.Transition) and _is_of(link, blocked)
    }
    (page,) = flattened.net.pages
    for transition in transitions(flattened.net):
        for lower in gone.intersection(transition.overrides):
            transition.overrides.remove(lower)  # type: ignore[arg-type]
    gone |= {arc for arc in page.arcs if arc.source in gone or arc.target in gone}
    for part in gone:
        (page.arcs if isinstance(part, pn.Arc) else page.objects).remove(part)  # type: ignore[arg-type]
    trace = Trace(link for link in flattened.trace.links if link.target not in gone)
    return Flattened(flattened.net, trace), tuple(str(t.id) for t in blocked)
