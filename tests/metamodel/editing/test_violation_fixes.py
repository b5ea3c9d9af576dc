"""What fixes a violation takes it away, adds no error, and can be undone."""

from __future__ import annotations

import pytest

from dineros.metamodel.constraints import all_constraints, validate
from dineros.metamodel.editing.changes import undo
from dineros.metamodel.editing.editor import Editor
from dineros.metamodel.editing.violation_fixes import _FIXES, fix_of
from dineros.metamodel.files.xmi import xmi_bytes
from tests.support.broken import CASES
from tests.support.broken.cases import Case

FIXED = [case for case in CASES if case.constraint in _FIXES]


def test_fixes_are_of_constraints_that_there_are() -> None:
    assert set(_FIXES) <= {each.name for each in all_constraints()}
    assert {case.constraint for case in FIXED} == set(_FIXES)


@pytest.mark.parametrize("case", FIXED, ids=str)
def test_a_fix_takes_the_violation_away(case: Case) -> None:
    small = case.make()
    case.break_(small)
    editor = Editor(small.net)
    is_finite = case.break_.__name__ != "endless_timeout"  # which no file can hold
    drawn = xmi_bytes(small.net) if is_finite else b""
    before = validate(small.net)
    found = [each for each in before if each.constraint == case.constraint]
    first = fix_of(found[0], editor.handles)
    if first is None:
        assert case.constraint in ("arc-on-page-of-its-ends", "read-or-inhibitor-arc-from-place")
        return
    done = editor.perform(first.commands)
    after = validate(small.net)
    assert sum(each.constraint == case.constraint for each in after) < len(found)
    errors = {each.constraint for each in before if each.severity == "error"}
    assert {each.constraint for each in after if each.severity == "error"} <= errors
    undo(done.changes)
    assert not is_finite or xmi_bytes(small.net) == drawn
