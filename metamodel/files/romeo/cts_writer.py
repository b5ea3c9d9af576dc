"""Writing Romeo's ``.cts``: places with their tokens, then transitions with guard and effect."""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import pn
from dineros.metamodel.files.romeo.net_of_romeo import NetOfRomeo
from dineros.metamodel.files.tina.writer import Flow, flows_of


def cts_text(net: pn.Net, path: Path | None = None) -> str:
    """Return a net in Romeo's language; `path` is named in messages.

    Names are the ids, with ``_`` for characters that Romeo does not take.

    Raises
    ------
    ModelFileError
        The net holds what the format cannot say.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    return _CtsWriter(net, path).text()


class _CtsWriter(NetOfRomeo):
    def text(self) -> str:
        self._names |= _KEY_WORDS
        self._called: dict[pn.Node, str] = {
            node: self._identifier(node.id) for node in (*self._places, *self._transitions)
        }
        flows, ranks = flows_of(self._net), self._ranks()
        tokens = ", ".join(f"{self._called[place]}={place.tokens}" for place in self._places)
        lines = ["typedef int place;", "", f"initially {{ place {tokens}; }}" if tokens else "initially { }"]
        for transition, rank in zip(self._transitions, ranks, strict=True):
            lines += ["", *self._transition(transition, rank, flows[transition])]
        return "\n".join(lines) + "\n"

    def _transition(self, transition: pn.Transition, rank: int, flow: Flow) -> list[str]:
        guard: list[str] = []
        takes: list[str] = []
        effect: dict[str, str] = {}
        order = {place: at for at, place in enumerate(self._called)}
        for (place, kind), weight in sorted(flow.items(), key=lambda each: (order[each[0][0]], each[0][1])):
            name = self._called[place]
            if kind == "inhibitor":
                guard.append(f"{name} < {weight}")
            elif kind == "read":
                guard.append(f"{name} >= {weight + flow.get((place, 'normal'), 0)}")
            elif kind == "normal":
                guard.append(f"{name} >= {weight}")
                takes.append(f"{name} = {name} - {weight}")
                effect[name] = f" - {weight}{effect.get(name, '')}"
            else:
                effect[name] = f"{effect.get(name, '')} + {weight}"
        changes = [f"{name} = {name}{change}" for name, change in effect.items()]
        options = [f"priority={rank}"] * bool(rank)
        options += [f"intermediate {{ {', '.join(takes)}; }}"] * bool(takes)
        given = f"[{', '.join(options)}] " if options else ""
        return [
            f"transition {given}{self._called[transition]} {self._interval(transition)}",
            f"  when ({' and '.join(guard) or 'true'})",
            f"  {{ {', '.join(changes)}; }}" if changes else "  { }",
        ]

    def _interval(self, transition: pn.Transition) -> str:
        interval = transition.interval or pn.TimeInterval()
        left = "(" if interval.earliestExcluded else "["
        low = self._bound(transition, interval.earliest)
        if interval.latest is None:
            return f"{left}{low},inf)"
        high, right = self._bound(transition, interval.latest), ")" if interval.latestExcluded else "]"
        return f"{left}{low},{high}{right}"


_KEY_WORDS = frozenset(
    {"typedef", "int", "bool", "real", "void", "enum", "struct", "const", "place", "parameters", "initially"}
    | {"transition", "when", "intermediate", "true", "false", "and", "or", "not", "inf", "if", "else", "for"}
    | {"while", "return", "min", "max", "check", "graph", "simulate", "cost_rate", "control", "nodes", "log"}
)
"""Words that name nothing else there."""
