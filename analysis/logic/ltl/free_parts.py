"""Removes environment-controlled places (such as signals without fairness) before an LTL check.

A *free part* is a set of places that some transitions, its *movers*, change, and nothing else changes; movers
change no other places. All other transitions only test it, and whenever such a transition has all its other
conditions, the movers can drive the part to markings in which it is enabled, and in which it is not. No
observed transition and no fair mover belongs to it, and no strongly fair transition tests it. In the net
without the part, the tests are removed, and a transition *idle*, which changes nothing, is added for each
condition that movers need.

*Proof.* A run of the net becomes one of the smaller net by removing movers, or by *idle* forever if it ends
with movers only. A run of the smaller net becomes one of the net by firing movers before transitions that
test the part. Both have the same observed steps in the same order, up to unobserved steps; formulas that such
steps may change are refused. Weakly fair transitions that test no free part are enabled at the same times.
Those that test one can be disabled infinitely often by movers, so that the run is weakly fair to them in any
case.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.explicit.layout import learn_of_whole
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeEnabled, SomeFired
from dineros.analysis.logic.language.names import LimitedNames, Names
from dineros.analysis.logic.language.patience import is_patient
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.ltl.free_part import Arcs, FreePart, Local, PlaceConditions
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.graph_parts import representatives

MOST_PASSES = 256
"""Maximum number of rounds of a loop until the free parts are as at its beginning."""

MOST_KEPT = 4
"""Maximum number of smaller nets that are kept with a net."""

EXACTLY = "\0"
"""Prefix for the number of one transition, which no name in a model has."""


@dataclass(frozen=True, eq=False)
class _Rest:
    """What is left of a net without some free parts, regardless of the question; see `Smaller`."""

    parts: tuple[FreePart, ...]
    net: CompiledNet
    kept: tuple[int, ...]
    back: tuple[int | None, ...]
    idles: Mapping[int, tuple[FreePart, PlaceConditions]]
    tested: frozenset[int]


class _PartsOfNet:
    """What questions about a net share: its parts, and the latest smaller nets by their removed places.

    So the layout and the bounds of a smaller net are found once, for all fairness assumptions.
    """

    def __init__(self, net: CompiledNet) -> None:
        self._net = net
        self._parts: dict[tuple[int, ...], FreePart | None] = {}
        self._rests: OrderedDict[frozenset[int], _Rest] = OrderedDict()
        leader = representatives(range(len(net.places)), map(list, net.delta))
        #: Sets of places that are changed together, by a representative, and the transitions that do so.
        self.members: dict[int, list[int]] = {}
        self.movers: dict[int, list[int]] = {}
        for place, home in leader.items():
            self.members.setdefault(home, []).append(place)
        for t, change in enumerate(net.delta):
            if change:
                self.movers.setdefault(leader[next(iter(change))], []).append(t)

    def part(self, places: tuple[int, ...], movers: tuple[int, ...]) -> FreePart | None:
        """Return a part with its markings; None: there are too many."""
        if places not in self._parts:
            self._parts[places] = FreePart.of(self._net, places, movers)
        return self._parts[places]

    def rest(self, parts: Sequence[FreePart]) -> _Rest:
        """Return what is left of the net without some of its parts."""
        removed = frozenset(p for part in parts for p in part.places)
        if removed not in self._rests:
            self._rests[removed] = _rest(self._net, parts)
            if len(self._rests) > MOST_KEPT:
                self._rests.popitem(last=False)
        self._rests.move_to_end(removed)
        return self._rests[removed]


@dataclass(frozen=True, eq=False)
class Smaller:
    """A net without its free parts.

    Attributes
    ----------
    names : Names
        The elements of the smaller net that names refer to.
    back : tuple of int or None
        For each of its transitions, the one of the original net; None for an idle transition.
    idles : mapping
        Idle transition -> the part that moves, and the movers' conditions on the rest.
    disabled : tuple of int
        Weakly fair transitions of the original net that movers disable infinitely often.
    """

    original: CompiledNet
    parts: tuple[FreePart, ...]
    net: CompiledNet
    names: Names
    weak: tuple[str, ...]
    strong: tuple[str, ...]
    back: tuple[int | None, ...]
    idles: Mapping[int, tuple[FreePart, PlaceConditions]]
    disabled: tuple[int, ...]

    def lift(
        self, stem: Sequence[int], loop: Sequence[int]
    ) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Return a fair lasso of the original net for one of the smaller net; None: there is none."""
        walk = _Walk(self)
        for transition in stem:
            walk.fire(transition)
        if not loop:
            return tuple(walk.fired), ()
        fired_in_loop = {self.back[t] for t in loop}
        unfair = [t for t in self.disabled if t not in fired_in_loop]
        starts: dict[tuple[Local, ...], int] = {}
        for _ in range(MOST_PASSES):
            here = tuple(walk.local.values())
            if here in starts:
                at = starts[here]
                return tuple(walk.fired[:at]), tuple(walk.fired[at:])
            starts[here] = len(walk.fired)
            for transition in unfair:
                walk.disable(transition)
            for transition in loop:
                walk.fire(transition)
        return None


class _Walk:
    """A run of the smaller net, executed in the original net."""

    def __init__(self, smaller: Smaller) -> None:
        self._smaller, self._net = smaller, smaller.original
        initial = self._net.initial.tolist()
        self.marking: list[int] = initial
        self.local = {part: tuple(initial[p] for p in part.places) for part in smaller.parts}
        self.fired: list[int] = []
        self._free = {p for part in smaller.parts for p in part.places}

    def fire(self, transition: int) -> None:
        """Fire a transition of the smaller net, after the movers that enable it."""
        original = self._smaller.back[transition]
        if original is None:
            part, needs = self._smaller.idles[transition]
            here = self.local[part]
            self._fire(next(m for m in part.graph[here] if needs.implies(part.outside[m])))
            return
        for part in self._tested(original):
            self._drive(part, original, True)
        self._fire(original)

    def disable(self, transition: int) -> None:
        """Let free parts disable a transition that nothing else disables."""
        if self._net.is_enabled(transition, self.marking):
            self._drive(self._tested(transition)[0], transition, False)

    def _tested(self, transition: int) -> list[FreePart]:
        touched = self._net.tested(transition)
        return [part for part in self._smaller.parts if touched.intersection(part.places)]

    def _drive(self, part: FreePart, transition: int, is_to_hold: bool) -> None:
        way = part.driving(self._net, transition, self.local[part], self._free, is_to_hold)
        assert way is not None, "the part is not free"
        for mover in way:
            self._fire(mover)

    def _fire(self, transition: int) -> None:
        self.marking = self._net.fire(transition, self.marking)
        self.fired.append(transition)
        for part in self.local:
            self.local[part] = tuple(self.marking[p] for p in part.places)


def without_free_parts(
    net: CompiledNet,
    formula: Formula,
    bound: BoundAtoms,
    names: Names,
    weakly: Collection[int],
    strongly: Collection[int],
) -> Smaller | None:
    """Return the net without its free parts; None: it has none, or the formula counts steps."""
    if not is_patient(formula):
        return None
    parts = _free_parts(net, bound, weakly, strongly)
    return _smaller(net, parts, names, weakly, strongly) if parts else None


def _free_parts(
    net: CompiledNet, bound: BoundAtoms, weakly: Collection[int], strongly: Collection[int]
) -> list[FreePart]:
    parts = [part for part in _candidates(net, bound, {*weakly, *strongly}) if part is not None]
    while True:
        free = {p for part in parts for p in part.places}
        kept = [part for part in parts if _is_free(net, part, free, weakly, strongly)]
        if len(kept) == len(parts):
            return parts
        parts = kept


def _candidates(net: CompiledNet, bound: BoundAtoms, fair: Collection[int]) -> Iterable[FreePart | None]:
    """Yield sets of places that are changed together, by unobserved transitions without fairness."""
    known = net.once(_PartsOfNet)
    observed: set[int] = set()
    watched: set[int] = set(fair)
    for condition in bound.conditions.values():
        match condition:
            case Linear(factors):
                observed.update(factors)
            case SomeEnabled(transitions):
                watched |= transitions
                observed.update(*(net.tested(t) for t in transitions))
            case SomeFired(transitions):
                watched |= transitions
    for home, places in known.members.items():
        inside = known.movers.get(home, [])
        if inside and observed.isdisjoint(places) and watched.isdisjoint(inside):
            yield known.part(tuple(places), tuple(inside))


def _is_free(
    net: CompiledNet,
    part: FreePart,
    free: Collection[int],
    weakly: Collection[int],
    strongly: Collection[int],
) -> bool:
    for needs in part.outside.values():
        if any(place in free for place in (*needs.inputs, *needs.inhibitors)):
            return False
        # In each marking of the part, some mover must be able to continue.
        if any(
            all(not needs.implies(part.outside[mover]) for mover in movers) for movers in part.graph.values()
        ):
            return False
    inside, movers = set(part.places), set(part.movers)
    for t in range(len(net.transitions)):
        if t in movers or net.tested(t).isdisjoint(inside):
            continue
        if t in strongly:
            return False
        for is_to_hold in (True, False) if t in weakly else (True,):
            if any(part.driving(net, t, here, free, is_to_hold) is None for here in part.graph):
                return False
    return True


def _smaller(
    net: CompiledNet,
    parts: Sequence[FreePart],
    names: Names,
    weakly: Collection[int],
    strongly: Collection[int],
) -> Smaller:
    rest = net.once(_PartsOfNet).rest(parts)
    return Smaller(
        net,
        rest.parts,
        rest.net,
        _Named(
            names,
            {place: number for number, place in enumerate(rest.kept)},
            {t: (number,) for number, t in enumerate(rest.back) if t is not None},
        ),
        tuple(f"{EXACTLY}{t}" for t in weakly if t not in rest.tested),
        tuple(f"{EXACTLY}{t}" for t in strongly),
        rest.back,
        rest.idles,
        tuple(t for t in weakly if t in rest.tested),
    )


def _rest(net: CompiledNet, parts: Sequence[FreePart]) -> _Rest:
    free = {p for part in parts for p in part.places}
    movers = {t for part in parts for t in part.movers}
    kept = [place for place in range(len(net.places)) if place not in free]
    back: list[int | None] = []
    transitions: list[Transition] = []

    def add(name: str, needs: PlaceConditions, outputs: Arcs, original: int | None) -> None:
        by_name = [
            {net.places[p]: w for p, w in arcs.items()} for arcs in (needs.inputs, outputs, needs.inhibitors)
        ]
        transitions.append(Transition(name, *by_name))
        back.append(original)

    for t, name in enumerate(net.transitions):
        if t not in movers:
            needs = PlaceConditions.of(net, t, lambda p: p not in free)
            add(name, needs, {p: w for p, w in net.post.row(t) if p not in free}, t)
    idles: dict[int, tuple[FreePart, PlaceConditions]] = {}
    known: set[object] = set()
    for part in parts:
        for mover, needs in part.outside.items():
            if needs.key not in known:
                known.add(needs.key)
                idles[len(back)] = part, needs
                # The mover's name, which is free now.
                add(net.transitions[mover], needs, needs.inputs, None)
    smaller = CompiledNet.build({net.places[p]: int(net.initial[p]) for p in kept}, transitions)
    learn_of_whole(smaller, net, {place: number for number, place in enumerate(kept)})
    tested = frozenset(t for t in range(len(net.transitions)) if not free.isdisjoint(net.tested(t)))
    return _Rest(tuple(parts), smaller, tuple(kept), tuple(back), idles, tested)


class _Named(LimitedNames):
    """Names of a net without its free parts; `EXACTLY` and a number name one transition of the net."""

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions with a name."""
        if name.startswith(EXACTLY):
            return self.images[int(name.removeprefix(EXACTLY))]
        return super().transitions(name)
