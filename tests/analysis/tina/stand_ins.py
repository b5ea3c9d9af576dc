"""Stand-ins for TINA's programs: real executables of the same command lines. They are not TINA.

`tina` and `sift` explore the net that they are given, marking by marking; `selt` decides a formula on the
graph that they wrote, by an automaton and strong components; `pathto` looks for a way in it. The graph files
hold JSON, since nobody but they reads them. The environment variable of `FAULTS` names what they do wrong.
Imports stand where they are needed: programs are started often.
"""

from __future__ import annotations

import itertools
import json
import os
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Atom, Comparison, Deadlock, Fired, Formula
from tests.analysis.tina.selt_language import SUB, read
from tests.support.programs.warm_commands import program

if TYPE_CHECKING:
    from dineros.analysis.nets.compiled import CompiledNet

ROOT = Path(__file__).resolve().parents[3]
FAULTS = "TINA_STAND_IN_FAULTS"
PROGRAMS = ("tina", "sift", "selt", "pathto")
_COMPARE = {
    "<=": int.__le__,
    ">=": int.__ge__,
    "==": int.__eq__,
    "!=": int.__ne__,
    "<": int.__lt__,
    ">": int.__gt__,
}
Edge = tuple[str | None, int]


def install(folder: Path, *names: str, warm: Path | None = None) -> None:
    """Write the executables into a folder: forks of what serves at the socket `warm`, if given."""
    folder.mkdir(exist_ok=True)
    for name in names or PROGRAMS:
        path = folder / name
        path.write_text(
            program(warm, f"{__name__}:called", name)
            if warm
            else f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(ROOT)!r})\n"
            f"from tests.analysis.tina.stand_ins import main\nmain({name!r}, sys.argv[1:])\n",
            encoding="utf-8",
        )
        path.chmod(0o755)


def called() -> None:
    """Be the program that the first argument of this process names."""
    main(sys.argv[1], sys.argv[2:])


class Graph:
    """A marking graph, of which some states may not have been explored."""

    def __init__(self, net: CompiledNet) -> None:
        self.places = [*net.places, SUB]
        self.states: list[tuple[int, ...]] = [(*(int(n) for n in net.initial), 1)]
        self.edges: list[list[Edge]] = [[]]

    @classmethod
    def load(cls, file: str) -> Graph:
        graph = cls.__new__(cls)
        graph.__dict__.update(json.loads(Path(file).read_text("utf-8")))
        return graph

    def save(self, file: str) -> None:
        Path(file).write_text(json.dumps(self.__dict__), encoding="utf-8")

    def is_true(self, atom: Atom, step: Edge) -> bool:
        """Evaluate an atom at a state and the event that leaves it."""
        event, state = step
        match atom:
            case Comparison(terms, operator, bound):
                tokens = dict(zip(self.places, self.states[state], strict=True))
                return _COMPARE[operator](sum(k * tokens[name.text] for k, name in terms), bound)
            case Fired(name):
                return event == name.text
            case Deadlock():
                return not self.edges[state]
        raise AssertionError(atom)


def explore(
    net: CompiledNet, condition: Formula | None, depth_first: bool, limit: int | None = None
) -> Graph:
    """Explore until a state does not obey the condition; states seen, but not explored, are partial."""
    graph = Graph(net)
    known = {graph.states[0][:-1]: 0}
    todo = [0]
    while todo:
        state = todo.pop(-1 if depth_first else 0)
        if condition is not None and not _obeys(graph, net, condition, state):
            graph.stopped = state  # type: ignore[attr-defined]
            return graph
        if limit is not None and len(graph.states) > limit:
            return graph
        marking = graph.states[state][:-1]
        graph.states[state] = (*marking, 0)
        for t, name in enumerate(net.transitions):
            if net.is_enabled(t, marking):
                after = tuple(net.fire(t, marking))
                if after not in known:
                    known[after] = len(graph.states)
                    graph.states.append((*after, 1))
                    graph.edges.append([])
                    todo.append(known[after])
                graph.edges[state].append((name, known[after]))
    return graph


def _obeys(graph: Graph, net: CompiledNet, condition: Formula, state: int) -> bool:
    marking = graph.states[state][:-1]
    is_dead = not any(net.is_enabled(t, marking) for t in range(len(net.transitions)))

    def is_true(atom: Atom, step: Edge) -> bool:
        return is_dead if isinstance(atom, Deadlock) else graph.is_true(atom, step)

    return holds_on_lasso(condition, [], [(None, state)], is_true)


def counterexample(graph: Graph, formula: Formula, drops_ends: bool) -> tuple[list[str], list[str]] | None:
    """Return the events of a run on which a formula is false: a path and a cycle; None if there is none."""
    import networkx as nx

    automaton = translate(negated(formula))
    product: nx.MultiDiGraph[tuple[int, int]] = nx.MultiDiGraph()
    start = (0, automaton.initial)
    product.add_node(start)
    todo = [start]
    for state, q in todo:
        for event, target in graph.edges[state] or ([] if drops_ends else [(None, state)]):
            atoms = enumerate(automaton.atoms)
            letter = sum(1 << i for i, atom in atoms if graph.is_true(atom, (event, state)))
            for edge in automaton.edges[q]:
                if edge.reads(letter):
                    node = (target, edge.target)
                    if node not in product:
                        todo.append(node)
                    product.add_edge((state, q), node, event=event, marks=edge.marks)
    for component in nx.strongly_connected_components(product):
        part = product.subgraph(component)
        edges = list(part.edges(data=True))
        if not edges or any(not any(d["marks"] >> m & 1 for *_, d in edges) for m in range(automaton.marks)):
            continue
        here = next(iter(component))
        stem, loop = list(_events(product, start, here)), []
        wanted = [next(e for e in edges if e[2]["marks"] >> m & 1) for m in range(automaton.marks)] or edges[
            :1
        ]
        place = here
        for source, after, data in wanted:
            loop += [*_events(part, place, source), data["event"]]
            place = after
        loop += _events(part, place, here)
        return [e for e in stem if e], [e for e in loop if e]
    return None


def _events(graph: Any, start: object, end: object) -> Iterator[Any]:
    import networkx as nx

    for source, target in itertools.pairwise(nx.shortest_path(graph, start, end)):
        yield next(iter(graph[source][target].values()))["event"]


def main(name: str, arguments: list[str]) -> None:
    """Run a program; the trial net is answered rightly unless a fault says otherwise."""
    faults = set(filter(None, os.environ.get(FAULTS, "").split(",")))
    if any(each.startswith(("trial.", "stopped.")) for each in arguments):
        faults = {fault.removeprefix("trial ") for fault in faults if fault.startswith("trial ")}
    if f"{name} fails" in faults:
        print(f"{name}: something is wrong", file=sys.stderr)
        sys.exit(3)
    if f"{name} sleeps" in faults:
        time.sleep(60)
    if f"{name} babbles" in faults:
        print("Hello.")
        return
    {"tina": _tina, "sift": _sift, "selt": _selt, "pathto": _pathto}[name](arguments, faults)


def _net(file: str) -> CompiledNet:
    """Read a net; names are those of the file, where our ids have no white space."""
    from dineros.analysis.nets.models import compile_net
    from dineros.metamodel.elements import label, places, transitions
    from dineros.metamodel.files import load

    model = load(Path(file))
    names = {node.id: label(node) for node in (*places(model), *transitions(model))}
    net = compile_net(model)
    return replace(
        net,
        places=tuple(map(names.__getitem__, net.places)),
        transitions=tuple(map(names.__getitem__, net.transitions)),
    )


def _tina(arguments: list[str], faults: set[str]) -> None:
    assert arguments[0] == "-R", arguments
    files = [argument for argument in arguments if not argument.startswith("-")]
    net = _net(files[0])
    graph = explore(net, None, False, 3000)
    bounded = "not bounded" if any(state[-1] for state in graph.states) else "bounded"
    dead, arcs = graph.edges.count([]), sum(map(len, graph.edges)) + ("tina miscounts" in faults)
    print(f"# net net, {len(net.places)} places, {len(net.transitions)} transitions, 0 arcs")
    print(f"# {bounded}, not live, not reversible")
    print("# abstraction        count      props      psets       dead       live")
    print(f"#      states {len(graph.states):12} {len(net.places):10}    ? {dead:10}      0")
    print(f"# transitions {arcs:12} {len(net.transitions):10}    ?          0      0")
    if files[1:]:
        assert files[1].endswith(".ktz"), arguments
        graph.save(files[1])


def _sift(arguments: list[str], faults: set[str]) -> None:
    assert arguments[0] == "-R", arguments
    condition = None
    if "-f" in arguments:
        condition = read(arguments.pop(arguments.index("-f") + 1))
    source, target = (argument for argument in arguments if not argument.startswith("-"))
    early = 1 if "sift stops early" in faults else None
    graph = explore(_net(source), condition, "-df" in arguments, early)
    stopped = graph.__dict__.pop("stopped", None)
    graph.save(target)
    if stopped is not None:
        print("some state violates condition -f:")
        if "sift tells no number" not in faults:
            print(f"state {stopped + ('sift miscounts' in faults)}: {graph.states[stopped]}")
    print(f"{len(graph.states)} marking(s), {sum(map(len, graph.edges))} transition(s)")


def _selt(arguments: list[str], faults: set[str]) -> None:
    file, flag, text, *rest = arguments
    assert flag == "-f", arguments
    assert rest[0] == "-q", arguments
    assert rest[rest.index("-wp") + 1] == "0", arguments
    graph = Graph.load(file)
    found = counterexample(graph, read(text), "selt drops ends" in faults)
    holds = (found is None) is not ("selt lies" in faults)
    print("TRUE" if holds else "FALSE")
    if found is None or "-S" not in rest or "selt shows nothing" in faults:
        return
    assert "-s" in rest, arguments
    stem, loop = found
    if "selt shows another run" in faults:
        stem = [*stem, *stem, *loop, "t"]
    rows = [" ".join(map(_quoted, row)) for row in (stem, loop)]
    if "selt shows times" in faults:
        rows = [row.replace(" ", "@1 ") + "@1" for row in rows]
    if "selt shows no transition" in faults:
        rows.append("nix")
    Path(rest[rest.index("-S") + 1]).write_text("# by a stand-in\n" + "\n".join(rows), encoding="utf-8")


def _pathto(arguments: list[str], faults: set[str]) -> None:
    import networkx as nx

    rank, flag, file = arguments
    assert flag == "-t", arguments
    graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()
    graph.add_node(0)
    for source, edges in enumerate(Graph.load(file).edges):
        for event, target in edges:
            graph.add_edge(source, target, event=event)
    events = list(_events(graph, 0, int(rank)))
    if "pathto goes astray" in faults:
        events = events[1:] + events[:1]
    print(" ".join(map(_quoted, events)))


def _quoted(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_']+", name) else "{" + re.sub(r"([{}\\])", r"\\\1", name) + "}"
