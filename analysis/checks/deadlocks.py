"""Why nothing can fire: deadlocks grouped by what waits for what, each with a way to it.

A transition *waits* in a dead marking where a token arrived at one of its inputs but something else is
missing. A token that was there from the start, a free place of a queue, or an instance without a request is
at rest and waits for nothing. Missing tokens would be made by other transitions, which lack tokens in
turn: if that leads to another waiting transition, the first one is a consequence. The remaining
transitions, alone or in a circle, are the cause. The transitions of a node that was shut down do not wait:
they end with their node. Dead markings in which the same transitions wait for the same places are one group;
server instances are alike.

If nothing waits, nothing is left to do. That is as it should be where the final condition of
the model holds, or, if it states none, where each node rests in final places. A place is final if it is of
the kind `end`; in a node without such a place, all from which nothing takes tokens are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.model.final_conditions import FinalCondition
from dineros.analysis.model.resting import doers, not_final, shut_down_marks, unused_marks
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.graph_parts import strongly_connected_parts
from dineros.analysis.nets.witness import last_marking
from dineros.analysis.symbolic.boxes import Box
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.symbolic.vector_sets import Scope
from dineros.metamodel import sym
from dineros.metamodel.records import Drop

#: Number of groups; from then on server instances count as alike, and all other markings are one more group.
MOST_GROUPS = 24
#: Causes named in a text.
MOST_NAMED = 4


@dataclass(frozen=True)
class Waiting:
    """A transition that lacks something."""

    transition: int
    """Its index in the net."""
    arrived: tuple[int, ...]
    """Input places where tokens arrived that are not at rest."""
    missing: tuple[int, ...]
    """Input places with too few tokens."""
    blocking: tuple[int, ...]
    """Places with an inhibitor arc and too many tokens."""


@dataclass(frozen=True)
class DeadlockGroup:
    """Dead markings with one cause."""

    markings: int
    """How many there are."""
    causes: tuple[Waiting, ...]
    """What waits for what; empty if nothing waits."""
    trace: tuple[int, ...]
    """Transitions that lead to one of them."""
    is_rest: bool = False
    """Whether these are what is left after `MOST_GROUPS` groups; the causes are those of one marking then."""
    has_others: bool = False
    """Whether some of the markings have these causes at other server instances."""
    unfinished: tuple[int, ...] = ()
    """Where nothing waits: places with tokens that are not final, though nothing takes tokens from them."""
    is_final: bool | None = None
    """Whether the final condition of the model holds; None if it states none."""


def is_finished(subject: Subject, group: DeadlockGroup) -> bool:
    """Return whether a group of dead markings is a finished scenario of an application: no fault."""
    if group.is_final is not None:
        return group.is_final
    is_application = isinstance(subject.model, sym.SystemModel)
    return is_application and not group.causes and not group.unfinished and not group.is_rest


def deadlock_groups(
    subject: Subject, space: SymbolicStateSpace, final: FinalCondition | None = None
) -> list[DeadlockGroup]:
    """Group the reachable markings that enable nothing by their causes.

    Raises
    ------
    DiagramMemoryError
        If memory runs out.
    """
    return merged(subject, _groups(subject, space, final))


def merged(subject: Subject, groups: Iterable[DeadlockGroup]) -> list[DeadlockGroup]:
    """Return groups of dead markings, those with the same causes as one."""
    found: dict[object, DeadlockGroup] = {}
    for group in groups:
        key = (
            group.is_rest,
            group.is_final,
            _without_instances(subject, group.causes),
            group.unfinished,
        )
        first = found.setdefault(key, group)
        if first is not group:
            has_others = first.has_others or group.causes != first.causes
            found[key] = replace(first, markings=first.markings + group.markings, has_others=has_others)
    return list(found.values())


def group_at(
    subject: Subject,
    trace: Sequence[int],
    final: FinalCondition | None = None,
    ignored: Collection[int] = (),
) -> DeadlockGroup:
    """Return a dead marking as a group of its own.

    Parameters
    ----------
    trace : sequence of int
        Transitions that lead to the marking.
    ignored : collection of int
        Places whose tokens mean nothing for a deadlock, such as values of signals.
    """
    marking, places = last_marking(subject.net, trace), _RestPlaces(subject)
    is_final = None if final is None else final.holds_at(marking)
    for place in ignored:
        marking[place] = places.initial[place]
    causes = places.causes(marking)
    unfinished = places.unfinished(marking, causes)
    return DeadlockGroup(1, causes, tuple(trace), unfinished=unfinished, is_final=is_final)


def _without_instances(subject: Subject, causes: Sequence[Waiting]) -> object:
    def origin(name: str) -> object:
        link = subject.link_of(name)
        return name if link is None else (link.rule, link.role, *link.sources)

    net = subject.net
    return frozenset(
        (origin(net.transitions[cause.transition]), frozenset(origin(net.places[p]) for p in cause.missing))
        for cause in causes
    )


def _groups(
    subject: Subject, space: SymbolicStateSpace, final: FinalCondition | None
) -> Iterator[DeadlockGroup]:
    places = _RestPlaces(subject)
    ways = SymbolicSets(space)
    sets = ways.sets
    with Scope(space.diagram) as scope:
        rest = sets.without_boxes(space.diagram.root, space.event_masks())
        scope.hold(rest)
        is_final = None
        if final is not None:
            ended, is_final = sets.intersection(rest, final.among(space)), False
            scope.hold(rest, ended)
            if ended:
                count, trace = DiagramCounts(space.diagram, ended).vectors(), ways.way_to(ended)
                yield DeadlockGroup(count, (), trace, is_final=True)
                rest = sets.difference(rest, ended)
                scope.hold(rest)
        number = 0
        while rest:
            marking = space.marking_of(sets.some_vector(rest))
            causes = places.causes(marking)
            unfinished = places.unfinished(marking, causes)
            number += 1
            is_rest = number > MOST_GROUPS
            others = 0 if is_rest else _without(space, rest, places, marking, causes)
            scope.hold(rest, others)
            group = sets.difference(rest, others)
            scope.hold(rest, others, group)
            trace = ways.way_to(group)
            count = DiagramCounts(space.diagram, group).vectors()
            yield DeadlockGroup(count, causes, trace, is_rest, unfinished=unfinished, is_final=is_final)
            rest = others
            scope.hold(rest)


def group_text(subject: Subject, group: DeadlockGroup) -> str:
    """Return what a group of dead markings is, in the words of the model."""
    count = group.markings
    more = "more " if group.is_rest else ""
    if is_finished(subject, group):
        where = "" if count == 1 else f" in {count} markings"
        why = "its final condition holds" if group.is_final else "everything that was started has ended"
        return f"the application can come to rest{where}: nothing is left to do, {why}"
    start = (
        f"one {more}marking has no enabled transition"
        if count == 1
        else f"{count} {more}markings have no enabled transition"
    )
    if not group.causes and group.is_final is False:
        return f"{start}: nothing waits, but the final condition of the model does not hold"
    if group.unfinished:
        named = ", ".join(subject.place_text(place) for place in group.unfinished)
        return f"{start}: nothing waits, but tokens remain on places that are not final: {named}"
    if not group.causes:
        return f"{start}: nothing waits, and everything that was started has ended"
    texts = list(dict.fromkeys(_cause_text(subject, cause) for cause in group.causes))
    named = "; ".join(texts[:MOST_NAMED])
    rest = f"; and {len(texts) - MOST_NAMED} more" if len(texts) > MOST_NAMED else ""
    alike = " (likewise at other server instances)" if group.has_others else ""
    return f"{start}{', such as one where' if group.is_rest else ':'} {named}{rest}{alike}"


def _cause_text(subject: Subject, cause: Waiting) -> str:
    missing = " and ".join(subject.place_text(place) for place in cause.missing)
    blocking = " and ".join(subject.place_text(place) for place in cause.blocking)
    wanted = [f"waits for: {missing}"] if missing else []
    wanted += [f"is blocked by: {blocking}"] if blocking else []
    return f"{subject.transition_text(cause.transition)} ({'; '.join(wanted)})"


class _RestPlaces:
    """What the places of a net hold at rest, and what waits in a marking."""

    def __init__(self, subject: Subject) -> None:
        self.net = net = subject.net
        known = {link.target.id: link.meaning for link in subject.links() if link.meaning is not None}
        resting = {place for place, name in enumerate(net.places) if name in known and known[name].rests}
        self.initial = net.initial.tolist()
        self.transitions = [
            t for t, name in enumerate(net.transitions) if name not in known or known[name].step is not Drop
        ]
        #: Places whose tokens may wait for something.
        self.waiting = sorted(
            {place for t in self.transitions for place, _ in net.pre.row(t) if place not in resting}
        )
        self._may_wait = set(self.waiting)
        self._excused = {t: [mark] for t, mark in unused_marks(subject).items()}
        gone = shut_down_marks(subject)
        for t, node in doers(subject).items():
            if node in gone:
                self._excused.setdefault(t, []).append(gone[node])
        #: Places from which nothing takes tokens, and that are not final, until this place is marked.
        self.not_final = {
            place: gone.get(node) if node is not None else None
            for place, node in not_final(subject).items()
            if place not in self._may_wait
        }
        self._makers: list[list[int]] = [[] for _ in net.places]
        self._takers: list[list[int]] = [[] for _ in net.places]
        for t in self.transitions:
            for place, tokens in net.delta[t].items():
                (self._makers if tokens > 0 else self._takers)[place].append(t)

    def causes(self, marking: Sequence[int]) -> tuple[Waiting, ...]:
        """Return what waits in a dead marking and is not consequence of something else that waits."""
        lacks = {t: self._waiting(t, marking) for t in self.transitions}
        waiting = {t for t in self.transitions if lacks[t].arrived and not self.excuses(t, marking)}
        needs = {
            t: [maker for place in found.missing for maker in self._makers[place]]
            + [taker for place in found.blocking for taker in self._takers[place]]
            for t, found in lacks.items()
        }
        leads_on: dict[int, bool] = {}  # whether its part, or what that needs, holds something that waits
        causes: list[int] = []
        for part in strongly_connected_parts(needs):
            here = [t for t in part if t in waiting]
            further = any(leads_on.get(other, False) for t in part for other in needs[t])
            leads_on.update(dict.fromkeys(part, further or bool(here)))
            causes += [] if further else here
        return tuple(lacks[t] for t in sorted(causes))

    def unfinished(self, marking: Sequence[int], causes: Sequence[Waiting]) -> tuple[int, ...]:
        """Return the places with tokens that are not final, in a dead marking in which nothing waits."""
        if causes:
            return ()
        return tuple(
            place
            for place, mark in self.not_final.items()
            if marking[place] > self.initial[place] and not (mark is not None and marking[mark])
        )

    def _waiting(self, transition: int, marking: Sequence[int]) -> Waiting:
        inputs = self.net.pre.row(transition)
        inhibitors = self.net.inhibitor.row(transition)
        return Waiting(
            transition,
            tuple(place for place, _ in inputs if self._has_arrived(place, marking)),
            tuple(place for place, weight in inputs if marking[place] < weight),
            tuple(place for place, weight in inhibitors if marking[place] >= weight),
        )

    def _has_arrived(self, place: int, marking: Sequence[int]) -> bool:
        return place in self._may_wait and marking[place] > self.initial[place]

    def excuses(self, transition: int, marking: Sequence[int]) -> list[int]:
        """Return marked places that say why a transition waits for nothing: its instance or node rests."""
        return [mark for mark in self._excused.get(transition, ()) if marking[mark] > 0]

    def all_excuses(self, marking: Sequence[int]) -> set[int]:
        """Return the marked places that excuse tokens: those of rest instances, and of nodes shut down."""
        found = ((t, self.excuses(t, marking)) for t in self._excused)
        marks = {mark for t, marks in found if marks and self._waiting(t, marking).arrived for mark in marks}
        return marks | {
            mark
            for place, mark in self.not_final.items()
            if mark is not None and marking[mark] and marking[place] > self.initial[place]
        }

    def box(self, causes: Sequence[Waiting], marking: Sequence[int], bounds: Sequence[int]) -> Box:
        """Return what the markings of a group share: where tokens arrived, are missing and are in the way."""
        box: Box = {}

        def narrow(place: int, low: int, high: int) -> None:
            before = box.get(place, (0, bounds[place]))
            box[place] = (max(before[0], low), min(before[1], high))

        for cause in causes:
            for place in cause.arrived:
                narrow(place, self.initial[place] + 1, bounds[place])
            for place, weight in self.net.pre.row(cause.transition):
                enough = marking[place] >= weight
                narrow(place, weight if enough else 0, bounds[place] if enough else weight - 1)
            for place, weight in self.net.inhibitor.row(cause.transition):
                if place in cause.blocking:
                    narrow(place, weight, bounds[place])
        return box


def _without(
    space: SymbolicStateSpace,
    states: int,
    places: _RestPlaces,
    marking: Sequence[int],
    causes: Sequence[Waiting],
) -> int:
    """Return the dead markings that are not of the group of one of them."""
    sets, encoding = space.sets, space.encoding
    bounds = encoding.boxes.bounds
    try:
        if causes:
            return sets.without_boxes(states, encoding.masks(places.box(causes, marking, bounds)))
        moved = [  # where tokens arrived that did not in this marking
            mask
            for place in (*places.waiting, *places.not_final)
            if marking[place] <= places.initial[place] < bounds[place]
            for mask in encoding.masks({place: (places.initial[place] + 1, bounds[place])})
        ]
        for mark in places.all_excuses(marking):
            moved += encoding.masks({mark: (0, 0)})
    except ValueError:  # a guard on a determined place that is not a small number of boxes
        return 0
    rests = {place: (places.initial[place] + 1, bounds[place]) for place in places.unfinished(marking, ())}
    with Scope(space.diagram) as scope:
        calm = sets.without_boxes(states, moved)
        scope.hold(states, calm)
        if rests:
            elsewhere = sets.without_boxes(calm, encoding.masks(rests))
            scope.hold(states, calm, elsewhere)
            calm = sets.difference(calm, elsewhere)
            scope.hold(states, calm)
        return sets.difference(states, calm)
