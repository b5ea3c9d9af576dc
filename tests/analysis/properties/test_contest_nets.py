"""A random tenth of the contest's small nets, where its folder is beside the project: no answer is wrong."""

from __future__ import annotations

import json
import tarfile
from pathlib import Path
from random import Random

import pytest

from benchmarks.contest.archives import unpack
from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.models import compile_net
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
from dineros.analysis.properties.reading import read_properties
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel.files import load

FOLDER = Path(__file__).resolve().parents[4] / "shared/mcc"
SEED, SHARE = 20231, 0.1
FILES = (
    "ReachabilityCardinality",
    "ReachabilityFireability",
    "UpperBounds",
    "CTLCardinality",
    "CTLFireability",
    "LTLCardinality",
    "LTLFireability",
)
#: Markings up to which a net is small.
SMALL = 20_000


def chosen_nets() -> list[str]:
    """Names of small nets, a tenth of all nets."""
    if not (FOLDER / "expected.json").exists():
        return []
    expected = json.loads((FOLDER / "expected.json").read_text())
    small = [n for n in sorted(expected) if 0 < expected[n].get("StateSpace", {}).get("STATES", 0) <= SMALL]
    return Random(SEED).sample(small, round(SHARE * len(expected)))


@pytest.mark.long
@pytest.mark.skipif(not FOLDER.exists(), reason="the contest's nets are not part of the project")
def test_a_tenth_of_the_nets(tmp_path: Path) -> None:
    expected = json.loads((FOLDER / "expected.json").read_text())
    wrong, unknown, right = [], [], 0
    for name in chosen_nets():
        unpack(FOLDER / "nets" / f"{name}.tgz", tmp_path)
        net = compile_net(load(tmp_path / name / "model.pnml"))
        names = GroupedNames(NetNames(net))
        asked = [one for file in FILES for one in read_properties(tmp_path / name / f"{file}.xml", names)]
        asked += [Property(question, "global", examination=question) for question in GLOBAL_PROPERTIES]
        verdicts = {id: v for examination in expected[name].values() for id, v in examination.items()}
        answers = {a.id: a.value for a in answer_properties(net, names, asked, seconds=1.0, memory=1 << 29)}
        space = state_space(net, budget=Budget(1 << 29))
        answers |= {"STATES": space.states, "TRANSITIONS": space.arcs}
        for id, value in answers.items():
            if value is None:
                unknown.append(id)
            elif id in verdicts and value != verdicts[id]:
                wrong.append(id)
            else:
                right += 1
    assert wrong == []
    assert right >= 1_000
    assert len(unknown) <= right // 50, "nets this small leave next to nothing open"


def test_an_archive_is_unpacked_in_its_folder_only(tmp_path: Path) -> None:
    (tmp_path / "here").write_text("a net")
    for name, is_within in (("net/model.pnml", True), ("../model.pnml", False)):
        archive = tmp_path / "net.tgz"
        with tarfile.open(archive, "w:gz") as files:
            files.add(tmp_path / "here", name)
        folder = tmp_path / "folder"
        if is_within:
            unpack(archive, folder)
            assert (folder / name).read_text() == "a net"
        else:
            with pytest.raises(tarfile.TarError):
                unpack(archive, folder)
            assert not (tmp_path / "model.pnml").exists()
