"""Whatever is sent, a model can be saved and read; it is undone to the byte, and done again to the byte."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn
from dineros.metamodel.base import features_of
from dineros.metamodel.constraints import validate
from dineros.metamodel.editing import Document, decode_commands
from dineros.metamodel.editing.changes import Change, redo, undo
from dineros.metamodel.editing.composed import compose, decode_operation
from dineros.metamodel.editing.editor import Editor
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.editing.journal import journal_of
from dineros.metamodel.editing.storing import read_content
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from dineros.metamodel.files.xmi import xmi_bytes
from tests.metamodel.editing.random_commands import Drawer
from tests.support.equality import differences
from tests.support.systems.small_systems import small_system_models
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


def state(net: pn.Net) -> tuple[bytes, list[str]]:
    """Return a model's bytes, and the order of the lists that no file holds."""
    lists = [
        f"{feature.name}: {[id(each) for each in getattr(element, feature.name)]}"
        for element in subtree(net)
        for feature in features_of(type(element)).values()
        if feature.many and feature.transient
    ]
    return xmi_bytes(net), lists


@pytest.mark.long
@settings(max_examples=15)
@given(model=st.one_of(st.builds(talker), small_system_models()), random=st.randoms(use_true_random=False))
def test_any_stream_of_commands(model: pn.Net, random: Random) -> None:
    editor = Editor(model)
    drawer = Drawer(editor, random)
    begin = state(model)
    history: list[list[Change]] = []
    for _ in range(30):
        before, count = state(model), len(editor.handles)
        try:
            if random.random() < 0.3:
                operation = decode_operation(drawer.operation())
                performed = editor.perform(compose(model, editor.handles, operation))
            else:
                performed = editor.perform(decode_commands(drawer.group()))
        except DinerosError as error:
            assert str(error) and "\n" not in str(error)
            assert state(model) == before and len(editor.handles) == count
        else:
            history.append(performed.changes)
    end = state(model)
    assert differences(model, read_content(end[0], Path("model.xmi"))) == []
    validate(model)
    for changes in reversed(history):
        undo(changes)
    assert state(model) == begin
    for changes in history:
        redo(changes)
    assert state(model) == end


def undo_all(document: Document) -> int:
    """Undo everything; return how many groups that were."""
    count = 0
    while document.undo_label is not None:
        document.undo()
        count += 1
    return count


@pytest.mark.long
@pytest.mark.parametrize("suffix", [".sym.xmi", ".pnml"])
def test_two_hundred_edits_of_the_case_study(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"sorting{suffix}"
    shutil.copy(CASE_STUDY.with_name(f"sorting{suffix}"), file)
    before = file.read_bytes()
    document = Document(file)
    drawer, random, done = Drawer(document._editor, Random(7)), Random(3), 0
    while done < 200:
        try:
            turn = random.random()
            if turn < 0.1:
                found = document.undo()
            elif turn < 0.15:
                found = document.redo()
            elif turn < 0.35:
                operation = decode_operation(drawer.operation())
                found = document.do(compose(document.root, document.handles, operation))
            else:
                found = document.do(decode_commands(drawer.group()))
            done += bool(found.touched)  # what was as it was wanted is in no journal
        except DinerosError:
            continue
    ended = xmi_bytes(document.root)
    os.close(document._journal._file)  # as if it were killed
    document = Document(file)
    assert document.recovered == 200
    assert xmi_bytes(document.root) == ended
    undone = undo_all(document)
    assert undone > 100
    assert document.content().data == before == document.save().data == file.read_bytes()
    for _ in range(undone):
        document.redo()
    assert xmi_bytes(document.root) == ended
    undo_all(document)
    document.save()
    document.close()
    assert differences(load(file), load(CASE_STUDY)) == [] and not journal_of(file).exists()
