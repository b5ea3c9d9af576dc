"""Nets of other tools: one note, all errors together, answers about the net that is meant."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Run

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


def test_all_complaints_at_once(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "net.pnml"
    path.write_text(
        INHIBITED.format('type="reset"/>').replace('id="done"', 'id="done" tokens="x"'), encoding="utf-8"
    )
    result = run("validate", path)
    assert (result.exit_code, result.stdout) == (2, "")
    assert [line.split(":")[1] for line in result.stderr.splitlines()] == ["2", "4"]
