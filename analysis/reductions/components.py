"""Independent components: parts of a net whose places other transitions can only test.

A component is a set S of places such that every transition which changes a place of S has arcs with S only.
All other transitions can only test S. Its *component graph* is the reachability graph of S alone. Input
signals that can change at any time (variant `fully-enabled`) are such components: ``s``, ``not s`` and the
places of the disjunctions that use s.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from operator import add
from weakref import WeakKeyDictionary

from dineros.analysis.nets.graph_parts import ends, has_cycle, representatives
from dineros.analysis.reductions.net import Arcs, Change, MutableNet
from dineros.analysis.reductions.rule import ALL_PROPERTIES, Lift, Property, Question, Rule, Step
from dineros.analysis.reductions.transitions import DEAD_PRESERVES

#: Components with more markings than this are left alone.
LARGEST_COMPONENT = 1_024

Local = tuple[int, ...]
Graph = dict[Local, dict[str, Local]]

#: For each net, the results for its components, with the arcs, whose identities are part of the key.
_GRAPHS: WeakKeyDictionary[MutableNet, dict[object, tuple[tuple[Arcs, ...], Graph | None]]] = (
    WeakKeyDictionary()
)


@dataclass
class Component:
    """An independent component and its component graph.

    Attributes
    ----------
    successors : dict
        Component graph: marking -> transition -> next marking. Empty when it is too large.
    """

    places: tuple[str, ...]
    members: dict[str, Arcs]
    initial: Local
    successors: Graph = field(default_factory=dict)

    def explore(self) -> bool:
        """Fill the component graph; False when it has too many markings."""
        self.successors = {}
        todo = [self.initial]
        position = {place: p for p, place in enumerate(self.places)}
        rules = [
            (
                t,
                [(position[p], w) for p, w in arcs.inputs.items()],
                [(position[p], w) for p, w in arcs.inhibitors.items()],
                tuple(arcs.delta.get(p, 0) for p in self.places),
            )
            for t, arcs in self.members.items()
        ]
        for local in todo:
            here = self.successors[local] = {}
            for t, inputs, inhibitors, gains in rules:
                if all(local[p] >= w for p, w in inputs) and all(local[p] < w for p, w in inhibitors):
                    here[t] = tuple(map(add, local, gains))
            for target in here.values():
                if target not in self.successors:
                    self.successors[target] = {}
                    todo.append(target)
            if len(self.successors) > LARGEST_COMPONENT:
                return False
        return True

    def holds(self, arcs: Arcs, local: Local) -> bool:
        """Whether a marking of the component satisfies all conditions of a transition."""
        tokens = dict(zip(self.places, local, strict=True))
        return all(tokens.get(p, w) >= w for p, w in arcs.inputs.items()) and all(
            tokens.get(p, 0) < w for p, w in arcs.inhibitors.items()
        )

    @cached_property
    def ends(self) -> list[set[Local]]:
        """Bottom strongly connected components of the component graph, in which all its runs end."""
        return ends(self.graph)

    @property
    def graph(self) -> dict[Local, list[Local]]:
        """The successors of each marking of the component."""
        return {local: list(row.values()) for local, row in self.successors.items()}

    @cached_property
    def is_connected(self) -> bool:
        """Whether every marking of the component is reachable from every other one."""
        return len(self.ends[0]) == len(self.successors)

    @cached_property
    def is_live(self) -> bool:
        """Whether every member can fire again from every marking of the component."""
        return all(
            self.members.keys() == {t for local in end for t in self.successors[local]} for end in self.ends
        )

    @cached_property
    def never_stops(self) -> bool:
        """Whether every marking of the component has an endless run."""
        return all(any(self.successors[local] for local in end) for end in self.ends)

    def path(self, start: Local, arcs: Arcs) -> tuple[list[str], Local] | None:
        """Return a shortest run to a marking that satisfies a transition, and that marking."""
        origin: dict[Local, tuple[Local, str] | None] = {start: None}
        queue = deque([start])
        while queue:
            local = queue.popleft()
            if self.holds(arcs, local):
                run, here = [], local
                while (step := origin[here]) is not None:
                    here = step[0]
                    run.append(step[1])
                return run[::-1], local
            for t, target in self.successors[local].items():
                if target not in origin:
                    origin[target] = (local, t)
                    queue.append(target)
        return None


def independent_components(net: MutableNet) -> list[Component]:
    """Return the minimal independent components."""
    deltas = {t: arcs.delta for t, arcs in net.transitions.items()}
    leader = representatives(net.places, map(list, deltas.values()))
    order = {place: position for position, place in enumerate(net.places)}
    places: dict[str, list[str]] = {}
    for place, root in leader.items():
        places.setdefault(root, []).append(place)
    members: dict[str, dict[str, Arcs]] = {root: {} for root in places}
    for t, delta in deltas.items():
        for place in delta:
            root = leader[place]
            members[root][t] = net.transitions[t]
            if any(leader[other] != root for other in net.transitions[t].places):
                places.pop(root, None)
            break
    found = [(root, group) for root, group in places.items() if members[root]]
    found.sort(key=lambda item: order[item[1][0]])
    return [Component(tuple(g), members[r], tuple(net.places[p] for p in g)) for r, g in found]


def explored(net: MutableNet, component: Component) -> bool:
    """Fill the graph of a component of a net; False: it has too many markings.

    Rules examine the same components repeatedly while other parts of the net change.
    """
    known = _GRAPHS.setdefault(net, {})
    arcs = tuple(component.members.values())
    key = component.places, component.initial, tuple(component.members), tuple(map(id, arcs))
    if key not in known:
        known[key] = arcs, component.successors if component.explore() else None
    graph = known[key][1]
    component.successors = graph or {}
    return graph is not None


def readers(net: MutableNet, component: Component) -> dict[str, Arcs]:
    """The transitions outside a component that test its places."""
    names = dict.fromkeys(t for place in component.places for t in net.neighbours(place))
    return {t: net.transitions[t] for t in names if t not in component.members}


class UnreadableTransition(Rule):
    """Remove a transition that requires a marking its component never has: its clause is never true.

    *Proof.* The markings of a component in the net are at most those of its component graph.
    """

    preserves = DEAD_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every transition that an independent component always disables."""
        for component in independent_components(net):
            tests = readers(net, component)
            if tests and explored(net, component):
                for t, arcs in tests.items():
                    if t not in question.observed_transitions and not any(
                        component.holds(arcs, local) for local in component.successors
                    ):
                        yield self.step(component.places, (t,), net.removing_transitions([t]))


class IndependentComponent(Rule):
    """Remove an independent component whose tests can always be satisfied again.

    Conditions: the component graph is finite, and from each of its markings, whatever one outside transition
    asks of the component can be reached inside the component, for each outside transition.

    *Proof.* Let N be the net and N' the rest without the component. Forgetting the component's firings and
    tokens turns a run of N into one of N'. Conversely, before each step t of a run of N', the component can
    be driven, on its own, to where it satisfies t; with several components, each is driven on its own. So
    both reach the same markings of the rest (`KEPT_PLACES`, `BOUNDEDNESS`). If the component graph is
    strongly connected, or nothing tests the component, every marking of the rest occurs with every marking of
    the component: N has their product (`STATE_SPACE_SIZE`, `MARKINGS`). If every marking of the component has
    an endless run, N never deadlocks and each of its runs may continue forever inside the component alone; a
    transition without arcs, *idle*, that is put into N' does the same (`DEADLOCKS`, `LTL_WITHOUT_NEXT`). If
    the component graph has no cycle, every run of it stops in a marking without successors, which satisfies
    all tests, so N stops iff N' stops. In other cases neither is claimed. Members are live in N iff they are
    in the component graph, and others iff they are in N' (`LIVENESS`).
    """

    preserves = ALL_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every removable component, also those that became independent by removing others."""
        number = -1
        while number != len(net.places):
            number = len(net.places)
            yield from self._steps(net, question)

    def _steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        for component in independent_components(net):
            if not question.observed_places.isdisjoint(component.places):
                continue
            # Removing the whole net would mean exploring its state space, which is not the task of a
            # reduction.
            if len(component.places) == len(net.places):
                continue
            if not question.observed_transitions.isdisjoint(component.members):
                continue
            if not explored(net, component):
                continue
            tests = readers(net, component)
            # Every run can be continued into an end, so being satisfiable in each end is being so from
            # everywhere.
            if all(
                any(component.holds(arcs, local) for local in end)
                for arcs in tests.values()
                for end in component.ends
            ):
                yield self._step(net, component, tests)

    def _step(self, net: MutableNet, component: Component, tests: dict[str, Arcs]) -> Step:
        preserved = set(self.preserves)
        if tests and not component.is_connected:
            preserved -= {Property.STATE_SPACE_SIZE, Property.MARKINGS}
        if not component.is_live:
            preserved.discard(Property.LIVENESS)
        added = {t: arcs.without(component.places) for t, arcs in tests.items()}
        idle: str | None = None
        if component.never_stops:
            idle = net.fresh_transition(f"idle({next(iter(component.members))})")
            added[idle] = Arcs({}, {}, {})
        elif has_cycle(component.graph):
            preserved -= {Property.DEADLOCKS, Property.LTL_WITHOUT_NEXT}
        change = Change(
            removed_places=dict(zip(component.places, component.initial, strict=True)),
            removed_transitions={**component.members, **tests},
            added_transitions=added,
        )
        markings = tuple(dict(zip(component.places, local, strict=True)) for local in component.successors)
        return self.step(
            component.places,
            component.members,
            change,
            preserved,
            lift=_driving(component, tests, idle),
            component=markings,
            dead_ends=1 if component.never_stops else len(component.ends),
        )


def _driving(component: Component, tests: dict[str, Arcs], idle: str | None) -> Lift:
    anything = Arcs({}, {}, {})

    def lift(_before: MutableNet, trace: list[str], settle: bool) -> list[str]:
        local = component.initial
        result: list[str] = []
        for t in trace:
            if t == idle:
                # An idle step represents any step of the component.
                member, local = next((m, s) for m, s in component.successors[local].items())
                result.append(member)
                continue
            found = component.path(local, tests.get(t, anything))
            assert found is not None, "the conditions of the rule say that it can be reached"
            run, local = found
            result += [*run, t]
        while settle and component.successors[local]:
            if component.never_stops:
                break
            member, local = next((m, s) for m, s in component.successors[local].items())
            result.append(member)
        return result

    return lift
