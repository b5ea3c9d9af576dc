"""Guards and assignments at random for any system model, and where its tokens are, by place and kind."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Iterable, Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import arcs, places, resolve, transitions
from dineros.transformations.flattening.flatten import Flattened
from dineros.transformations.language.copying import deep_copy
from tests.support.references.messages import ALL, Data

CONDITIONS = (
    "{0}.ok = true",
    "not {0}.ok = true",
    "{0}.level = 'LOW'",
    "{0}.level > 0",
    "{0}.level between 1 and 2 or {0}.ok = true",
    "{0}.ok = false and {0}.level <> 1",
)
_VALUES = {"false": 0, "true": 1, "LOW": 0, "MIDDLE": 1, "HIGH": 2}
_COLOUR = re.compile(r"(?P<place>.*)\[(?P<values>(?:level|ok)=[^:\[\]]*)\]")

Kind = tuple[frozenset[int], frozenset[int]]
"""The values of `ok` and of `level` that tokens of a colour may have."""


def decided(model: sym.SystemModel, dice: random.Random) -> sym.SystemModel:
    """Return a copy in which data decides: half of its transitions get a guard, and many assign values."""
    made, _ = deep_copy(model)
    assert isinstance(made, sym.SystemModel)
    made.tokenType = sym.TokenType(
        id="Token",
        fields=[
            sym.TokenField(name="ok", kind="boolean"),
            sym.TokenField(name="level", kind="integer", values="LOW=0, MIDDLE=1, HIGH=2"),
        ],
    )
    for each in places(made):
        if isinstance(each, sym.Place):
            each.tokenType = None
            each.balloons.clear()
            for ok, level in dice.choices(ALL, k=each.tokens):
                each.balloons.append(sym.BalloonToken(data=f'{{"ok": {str(ok).lower()}, "level": {level}}}'))
    takes: dict[pn.Node, list[pn.Arc]] = {}
    puts: dict[pn.Node, set[str]] = {}
    for arc in arcs(made):
        if arc.kind != pn.ArcKind.inhibitor:
            takes.setdefault(arc.target, []).append(arc)
            puts.setdefault(arc.source, set()).add(str(resolve(arc.target).id))
    for transition in transitions(made):
        assert isinstance(transition, sym.Transition)
        transition.overrides.clear()
        weights = Counter[str]()
        for arc in takes.get(transition, ()):
            weights[str(resolve(arc.source).id)] += arc.weight
        single = [f'"{name}"' for name, weight in weights.items() if weight == 1]
        if single and dice.random() < 0.5:
            asked = dice.sample(single, min(len(single), dice.randint(1, 2)))
            transition.guard = " and ".join(f"({dice.choice(CONDITIONS).format(name)})" for name in asked)
        if dice.random() < 0.5:
            given = [_assigned(name, single, dice) for name in sorted(puts.get(transition, ()))]
            transition.assigns = ", ".join(given) or None
    return made


def _assigned(name: str, single: list[str], dice: random.Random) -> str:
    if dice.random() < 0.5:
        return f'"{name}".ok := {dice.choice(["true", "false"])}'
    copied = bool(single) and dice.random() < 0.7
    return f'"{name}".level := ' + (f"{dice.choice(single)}.level" if copied else str(dice.randint(0, 2)))


def colours(flattened: Flattened) -> dict[str, list[tuple[str, Kind]]]:
    """Return by place of a net the places of the colours of its tokens; queues in order are left out."""
    found: dict[str, list[tuple[str, Kind]]] = {}
    for link in flattened.trace:
        if isinstance(link.target, pn.Place) and (link.rule, link.role) == ("Guard", "colour"):
            id = str(link.target.id)
            match = _COLOUR.fullmatch(id)
            if match:
                values = dict(part.split("=") for part in match["values"].split(","))
                kind = _known(values.get("ok", "0..1")), _known(values.get("level", "0..2"))
                found.setdefault(match["place"], []).append((id, kind))
    return found


def _known(text: str) -> frozenset[int]:
    found: set[int] = set()
    for part in text.split("|"):
        low, _, high = part.partition("..")
        first = _VALUES[low] if low in _VALUES else int(low)
        found.update(range(first, int(high or first) + 1))
    return frozenset(found)


def seen(
    tokens: Mapping[str, Iterable[Data]], ids: Iterable[str], kinds: Iterable[tuple[str, Kind]]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the number of tokens of each place, and of each pair of a place and a kind of its tokens."""
    held = {id: list(each) for id, each in tokens.items()}
    return tuple(len(held[id]) for id in ids), tuple(
        sum(int(ok) in oks and level in levels for ok, level in held[id]) for id, (oks, levels) in kinds
    )
