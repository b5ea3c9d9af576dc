"""Runtime models of a few elements, written as one line per transition."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.files import load
from dineros.runtime import Net, Node
from dineros.runtime.journal.recording import ListRecorder

ROOT = Path(__file__).resolve().parents[2]
FIELDS = [
    sym.TokenField(name="color"),
    sym.TokenField(name="count", kind="integer"),
    sym.TokenField(name="weight", kind="number"),
    sym.TokenField(name="done", kind="boolean"),
    sym.TokenField(name="pose", kind="list", elementKind="number", length=2),
    sym.TokenField(name="notes", kind="list"),
    sym.TokenField(name="marks", kind="map", elementKind="integer"),
]


def token_type() -> sym.TokenType:
    fields = [
        sym.TokenField(name=f.name, kind=f.kind, elementKind=f.elementKind, length=f.length) for f in FIELDS
    ]
    return sym.TokenType(id="Thing", name="Thing", fields=fields)


def tiny(
    transitions: Mapping[str, str],
    marking: Mapping[str, int | list[str]] | None = None,
    *,
    signals: str = "",
    clauses: Mapping[str, str] | None = None,
) -> rtm.RuntimeModel:
    """Return a runtime model.

    Parameters
    ----------
    transitions : mapping
        Id -> inputs and outputs, such as ``"a 2*b ?read !inhibitor -> c 2*d"``.
    marking : mapping
        Place -> number of tokens, or the data of each as JSON.
    signals, clauses
        Ids of signals; transition -> clause.
    """
    node = sym.NodeNet(id="node", name="node")
    model = rtm.RuntimeModel(
        id="tiny.node", systemModel="tiny", pages=[node], node=node, tokenType=token_type()
    )
    for signal in signals.split():
        sym.InputSignal(id=signal, node=node)
    places: dict[str, rtm.Place] = {}

    def place(id: str) -> rtm.Place:
        if id not in places:
            places[id] = rtm.Place(id=id, page=node)
        return places[id]

    for id, arcs in transitions.items():
        transition = sym.Transition(id=id, page=node)
        before, _, after = arcs.partition("->")
        for text in before.split():
            weight, _, name = text.lstrip("?!").rpartition("*")
            join = read if text[0] == "?" else inhibit if text[0] == "!" else flow
            join(place(name), transition, weight=int(weight or 1))
        for text in after.split():
            weight, _, name = text.rpartition("*")
            flow(transition, place(name), weight=int(weight or 1))
    for id, tokens in (marking or {}).items():
        if isinstance(tokens, int):
            place(id).tokens = tokens
        else:
            place(id).tokens = len(tokens)
            place(id).balloons.extend([sym.BalloonToken(data=data) for data in tokens])
    for id, text in (clauses or {}).items():
        set_clause(find(model, id, sym.Transition), text)
    return model


def case_study() -> sym.SystemModel:
    model = load(ROOT / "case_study/sorting.sym.xmi")
    assert isinstance(model, sym.SystemModel)
    return model


@contextlib.contextmanager
def stepped(net: Net) -> Iterator[tuple[Node, ListRecorder]]:
    """Open a node without a transport, to be stepped."""
    recorder = ListRecorder()
    node = Node(net, recorder=recorder)
    node.open()
    try:
        yield node, recorder
    finally:
        node.close()


def settle(node: Node, seconds: float = 20.0) -> None:
    """Step until nothing is in flight and nothing is left to do."""
    end = time.monotonic() + seconds
    while node.step() or node.net.inspect().in_flight or node.net.next_timer is not None:
        assert time.monotonic() < end, "it never settles"
        if not node.step():
            node.wait(0.02)


def events(recorder: ListRecorder, event: str) -> list[dict[str, object]]:
    return [record for record in recorder.records if record["event"] == event]


def counts(net: Net) -> dict[str, int]:
    return {place: len(tokens) for place, tokens in net.inspect().marking.items()}
