"""A model that nobody of this project made; it stays where it lies, beside the project."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree

from dineros.metamodel import sym
from dineros.metamodel.elements import find, node_nets, places, transitions
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml
from dineros.metamodel.files.pnml.vocabulary import Version
from tests.support.equality import differences
from tests.support.pnml import DINEROS, PNML, again, drawing

FILE = Path(__file__).resolve().parents[5] / "shared" / "models" / "AcomodiaFeatureSym.pnml"

pytestmark = pytest.mark.skipif(not FILE.exists(), reason=f"{FILE.name} is not beside the project")


@pytest.fixture
def model() -> sym.SystemModel:
    net = read_pnml(FILE)
    assert isinstance(net, sym.SystemModel)
    return net


def test_what_it_holds(model: sym.SystemModel) -> None:
    (node_net,) = node_nets(model)
    assert (node_net.id, str(node_net.executor), node_net.threads) == ("FeatureNode", "single", 1)
    loop = "{0}>{1} {1}>{2} {2}>{3} {3}>{4} {4}>{5} {5}>{0}"
    mode = ["P-LoopMode", "T-IntervalMode", "P1", "T-PollMode", "P2", "T-SubmitMode"]
    frame = ["P-LoopFrame", "T-IntervalFrame", "P3", "P4", "T-PollFrame", "T-SubmitFrame"]
    frame_loop = [frame[0], frame[1], frame[2], frame[4], frame[3], frame[5]]
    assert drawing(model) == {
        "root": ["FeatureNode"],
        "FeatureNode": ["ModeSwap", "FrameChange"],
        "ModeSwap": mode + loop.format(*mode).split(),
        "FrameChange": frame + loop.format(*frame_loop).split(),
    }
    assert {place.id: place.tokens for place in places(model) if place.tokens} == {"P-LoopMode": 1}
    assert {each.id for each in transitions(model) if each.interval} == {"T-IntervalMode", "T-IntervalFrame"}
    timed = find(model, "T-IntervalMode", sym.Transition)
    assert timed.interval is not None
    assert (timed.interval.earliest, timed.interval.latest, str(timed.kind)) == (1.0, 1.0, "timed")


def test_it_is_valid(model: sym.SystemModel) -> None:
    constraints = pytest.importorskip("dineros.metamodel.constraints")
    assert [each for each in constraints.validate(model) if each.severity == "error"] == []


@pytest.mark.parametrize("version", ["0.1", "0.2"])
def test_nothing_is_lost_from_the_model(model: sym.SystemModel, version: Version, tmp_path: Path) -> None:
    assert not differences(model, again(tmp_path, model, version))


def facts(root: etree._Element) -> set[tuple[str, ...]]:
    """Return every statement of a PNML file: names, texts, types, nesting; not the pages of arcs."""
    result = set()
    for xml in root.iter(etree.Element):
        owner = next((each for each in [xml, *xml.iterancestors()] if each.get("id")), xml)
        path = [each.tag.rpartition("}")[2] for each in [xml, *xml.iterancestors()]]
        path = path[: [each.get("id") for each in [xml, *xml.iterancestors()]].index(owner.get("id")) + 1]
        outer = owner.getparent()
        page = outer.get("id") if outer is not None and path[-1] != "arc" else None
        attributes = [f"{name!s}={value!s}" for name, value in sorted(xml.attrib.items())]
        result.add((*path, str(owner.get("id")), str(page), *attributes, (xml.text or "").strip()))
    return result


def test_nothing_is_lost_from_the_file(model: sym.SystemModel) -> None:
    before = facts(etree.parse(FILE).getroot())
    after = facts(etree.fromstring(pnml_bytes(model)))
    assert len(before) > 100
    assert before - after == set()
    added = {fact[0] for fact in after - before}
    assert added <= {"node", "subnet", "toolspecific"}  # every element says where it belongs


def test_it_needs_no_block_of_ours(model: sym.SystemModel) -> None:
    root = etree.fromstring(pnml_bytes(model))
    assert {each.get("tool") for each in root.iter(f"{{{PNML}}}toolspecific")} == {DINEROS}
