"""How long a timer's callback may take from its tick to its end, by an observer in the flattened net.

The observer follows one tick: copies of the tick, of the beginnings and of the ends pass a token on, and a
transition that fires exactly `seconds` after the tick tells whether the callback may take as long.
"""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.nets import compile_timed_net
from dineros.metamodel import pn, pnm


def may_take(net: pnm.PetriNetModel, callback: str, seconds: float) -> bool:
    """Tell whether a run of a timer's callback may end that long after its tick, or later.

    `net` gets the observer, so a net can be asked once.
    """
    observer = _Observer(net)
    watched = observer.place("armed")
    running = f"{callback}.running"
    waiting, begun, idle = observer.place("waiting"), observer.place("begun"), observer.place("idle", 1)
    (tick,) = observer.transitions_named(f"{callback}.tick")
    seen = observer.copy(tick)
    observer.join(idle, seen)
    observer.join(seen, waiting)
    observer.join(seen, watched)
    for begin in observer.into(running):
        copied = observer.copy(begin)
        observer.join(waiting, copied)
        observer.join(copied, begun)
        observer.join(waiting, begin, "inhibitor")
    for end in observer.out_of(running):
        copied = observer.copy(end)
        observer.join(begun, copied)
        observer.join(watched, copied)
        observer.join(begun, end, "inhibitor")
    late = pn.Transition(id="observer.late", page=observer.page)
    late.interval = pn.TimeInterval(earliest=seconds, latest=seconds)
    observer.join(watched, late)
    found = explore_timed(compile_timed_net(net), Budget(seconds=300))
    assert found.is_complete, found.reason
    return found.net.untimed.transitions.index("observer.late") in found.ways


class _Observer:
    def __init__(self, net: pnm.PetriNetModel) -> None:
        (self.page,) = net.pages
        self.nodes = {each.id: each for each in self.page.objects if isinstance(each, pn.Node)}
        self.count = 0

    def place(self, name: str, tokens: int = 0) -> pn.Place:
        return pn.Place(id=f"observer.{name}", tokens=tokens, page=self.page)

    def transitions_named(self, name: str) -> list[pn.Node]:
        return [node for id, node in self.nodes.items() if id == name]

    def into(self, place: str) -> list[pn.Node]:
        return [arc.source for arc in self.nodes[place].incoming]

    def out_of(self, place: str) -> list[pn.Node]:
        return [arc.target for arc in self.nodes[place].outgoing if arc.kind == pn.ArcKind.normal]

    def join(self, source: pn.Node, target: pn.Node, kind: str = "normal", weight: int = 1) -> None:
        self.count += 1
        arc = pn.Arc(id=f"observer.{self.count}", weight=weight, kind=kind, page=self.page)
        arc.source, arc.target = source, target

    def copy(self, transition: pn.Node) -> pn.Transition:
        assert isinstance(transition, pn.Transition)
        made = pn.Transition(id=f"observer.{transition.id}", page=self.page)
        if (given := transition.interval) is not None:
            made.interval = pn.TimeInterval(earliest=given.earliest, latest=given.latest)
        for arc in list(transition.incoming):
            if not arc.source.id.startswith("observer."):
                self.join(arc.source, made, str(arc.kind), arc.weight)
        for arc in list(transition.outgoing):
            self.join(made, arc.target, str(arc.kind), arc.weight)
        return made
