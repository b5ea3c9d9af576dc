"""Nets of other tools: one note, all errors together, answers about the net that is meant."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Run
from tests.metamodel.files.pnml.test_symmetric import NET as COLOURED

INHIBITED = """<pnml><net id="n" type="P/T net">
<place id="free"/><place id="busy" initialMarking="1"/><place id="done"/><transition id="go"/>
<arc id="a" source="busy" target="go"/><arc id="a" source="go" target="done"/>
<arc id="b" source="free" target="go" {}
</net></pnml>"""
ELEMENT = '><type value="inhibitor"/></arc>'
NOTES = ["no namespace", "net type 'P/T net'", "attribute initialMarking taken as the marking"]


@pytest.fixture(params=['type="inhibitor"/>', ELEMENT])
def inhibited(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / "net.pnml"
    path.write_text(INHIBITED.format(request.param), encoding="utf-8")
    return path


def test_one_note_lists_what_was_taken_as_what(run: Run, inhibited: Path) -> None:
    result = run("validate", inhibited)
    assert (result.exit_code, result.stdout) == (0, f"{inhibited}: valid\n")
    (note,) = result.stderr.splitlines()
    assert note.startswith(
        f"{inhibited}: note: this is not standard PNML; read as a P/T net: {'; '.join(NOTES)}; "
    )
    assert "1 arc id taken by another element, such as 'a' (lines 3 and 3), replaced" in note
    assert json.loads(run("validate", inhibited, "--json").stdout)["notes"][:3] == NOTES
    assert run("validate", inhibited, "-q").stderr == ""


def test_an_inhibitor_arc_is_one_in_every_form(run: Run, inhibited: Path) -> None:
    result = run("find", inhibited, "--marking", "done >= 1")
    assert (result.exit_code, result.stdout.splitlines()[0]) == (0, "reachable: done >= 1")


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (("--marking", "At <= 1"), "reachable: At <= 1"),
        (("--marking", "At = 0"), "unreachable: At = 0; 4 states"),
        (("--marking", "Never >= 1"), "unreachable: Never >= 1; 4 states"),
        (("--marking", '"At(a)" = 0'), 'unreachable: "At(a)" = 0; 4 states'),
        (("--enabled", "move"), "reachable: enabled(move)"),
    ],
)
def test_a_coloured_net_is_unfolded_and_asked_by_its_own_names(
    run: Run, tmp_path: Path, asked: tuple[str, str], answer: str
) -> None:
    path = tmp_path / "net.pnml"
    path.write_text(COLOURED, encoding="utf-8")
    result = run("find", path, *asked)
    assert result.stdout.splitlines()[0] == answer
    assert result.stderr == f"{path}: note: the coloured net is unfolded to 3 places and 2 transitions\n"


NAMED = """<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n"
type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">
<place id="cId-1"><name><text>Entry</text></name><initialMarking><text>1</text></initialMarking></place>
<place id="cId-2"><name><text>the exit</text></name></place>
<transition id="cId-3"><name><text>Go</text></name></transition>
<arc id="a" source="cId-1" target="cId-3"/><arc id="b" source="cId-3" target="cId-2"/></page></net></pnml>"""


def test_names_stand_for_generated_ids(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "net.pnml"
    path.write_text(NAMED, encoding="utf-8")
    by_name = run("find", path, "--marking", 'Entry = 0 & "the exit" >= 1')
    assert by_name.stdout == 'reachable: Entry = 0 & "the exit" >= 1\n    1  Go\n'
    assert run("find", path, "--marking", '"cId-1" = 0').stdout.splitlines()[1] == "    1  Go"
    assert run("find", path, "--enabled", "Go").exit_code == 0
    assert run("verify", path, "--ltl", "F fired(Go)").exit_code == 0
    step = json.loads(run("find", path, "--enabled", "Go", "--json").stdout)["witness"]
    assert step is not None


def test_all_complaints_at_once(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "net.pnml"
    path.write_text(
        INHIBITED.format('type="reset"/>').replace('id="done"', 'id="done" tokens="x"'), encoding="utf-8"
    )
    result = run("validate", path)
    assert (result.exit_code, result.stdout) == (2, "")
    assert [line.split(":")[1] for line in result.stderr.splitlines()] == ["2", "4"]
