"""Property files over symmetric nets, compared with an interpreter of coloured nets."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from dineros.analysis.model.names import PlainNames
from dineros.analysis.nets.models import compile_net
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import GroupedNames
from dineros.analysis.properties.reading import read_properties
from dineros.metamodel.files.pnml import read_pnml
from tests.support.references.coloured import Coloured, Marking, random_net

MOST = 150


def answered(tmp_path: Path, pnml: str, formulas: dict[str, str]) -> dict[str, object]:
    (tmp_path / "net.pnml").write_text(pnml, encoding="utf-8")
    inner = "".join(
        f"<property><id>{id}</id><description/><formula>{formula}</formula></property>"
        for id, formula in formulas.items()
    )
    (tmp_path / "asked.xml").write_text(
        f'<property-set xmlns="http://mcc.lip6.fr/">{inner}</property-set>', encoding="utf-8"
    )
    model = read_pnml(tmp_path / "net.pnml")
    net = compile_net(model)
    names = GroupedNames(PlainNames(net, model))
    asked = read_properties(tmp_path / "asked.xml", names)
    return {one.id: one.value for one in answer_properties(net, names, asked, seconds=5.0)}


def fireable(*transitions: str) -> str:
    inner = "".join(f"<transition>{each}</transition>" for each in transitions)
    return f"<is-fireable>{inner}</is-fireable>"


def sometime(formula: str) -> str:
    return f"<exists-path><finally>{formula}</finally></exists-path>"


def always(formula: str) -> str:
    return f"<all-paths><globally>{formula}</globally></all-paths>"


def tokens(marking: Marking, *places: str) -> int:
    return sum(number for place, _, number in marking if place in places)


@pytest.mark.parametrize("part", range(4))
def test_places_are_sums_and_transitions_any_of_their_bindings(tmp_path: Path, part: int) -> None:
    compared = 0
    for seed in range(50_000 + part, 50_048, 4):
        coloured = random_net(seed)
        graph = coloured.graph(MOST)
        if graph is None or len(graph) < 2:
            continue
        compared += 1
        formulas, expected = _asked(coloured, graph, random.Random(seed))
        assert answered(tmp_path, coloured.pnml(), formulas) == expected, seed
    assert compared >= 2


def _asked(
    net: Coloured, graph: dict[Marking, list[tuple[str, Marking]]], dice: random.Random
) -> tuple[dict[str, str], dict[str, object]]:
    """Return formulas, and what they are worth."""
    formulas: dict[str, str] = {}
    expected: dict[str, object] = {}
    for number in range(4):
        places = dice.sample(sorted(net.places), dice.randint(1, 2))
        most = max(tokens(marking, *places) for marking in graph)
        listed = "".join(f"<place>{place}</place>" for place in places)
        formulas[f"bound-{number}"] = f"<place-bound>{listed}</place-bound>"
        expected[f"bound-{number}"] = most
        wanted = dice.randint(0, most + 1)
        formulas[f"reach-{number}"] = sometime(
            f"<integer-le><integer-constant>{wanted}</integer-constant>"
            f"<tokens-count>{listed}</tokens-count></integer-le>"
        )
        expected[f"reach-{number}"] = most >= wanted
        fired = dice.sample(sorted(net.conditions), dice.randint(1, len(net.conditions)))
        enabling = [any(name in fired for name, _ in steps) for steps in graph.values()]
        formulas[f"fires-{number}"] = sometime(fireable(*fired))
        expected[f"fires-{number}"] = any(enabling)
        formulas[f"always-{number}"] = always(fireable(*fired))
        expected[f"always-{number}"] = all(enabling)
    formulas["stops"] = sometime("<deadlock/>")
    expected["stops"] = not all(graph.values())
    return formulas, expected


def test_an_id_goes_before_a_name(tmp_path: Path) -> None:
    """The name of a place is the id of another one, which has two colours."""
    net = Coloured({"D": ("dot",), "C": ("cyclic", ["a", "b"])}, {"x": "C"}, {}, {"t": None})
    net.places = {"Fork": ("C", ("all", "C")), "p": ("D", None)}
    net.takes, net.puts = (
        [("Fork", "t", ("variable", "x"))],
        [("p", "t", ("numberof", 3, ("constant", "D", "dot")))],
    )
    named = net.pnml().replace('<place id="p">', '<place id="p"><name><text>Fork</text></name>')
    assert answered(tmp_path, named, {"most": "<place-bound><place>Fork</place></place-bound>"}) == {
        "most": 2
    }
