"""Editing a file: saved to the byte, recovered after a kill, never over what somebody else wrote."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.editing import Command, CommandError, Document, decode_commands
from dineros.metamodel.editing.commands import Clause, Create, Delete, Move, Set
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.editing.journal import JournalError, journal_of
from dineros.metamodel.editing.storing import own_form, read_content
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError, ModelFileError
from dineros.metamodel.files import load, save
from tests.metamodel.editing.random_commands import Drawer
from tests.support.systems.talker import talker

ROOT = Path(__file__).resolve().parents[3]
CASE_STUDY = ROOT / "case_study/sorting.sym.xmi"
FEATURES = Path(__file__).resolve().parents[4] / "shared/models/AcomodiaFeatureSym.pnml"


def handle(document: Document, id: str) -> str:
    found = document.handles.of(find(document.root, id))
    assert found is not None
    return found


def changed_lines(before: bytes, after: bytes) -> list[tuple[bytes, bytes]]:
    pairs = zip(before.splitlines(), after.splitlines(), strict=True)
    return [pair for pair in pairs if pair[0] != pair[1]]


def killed(document: Document) -> None:
    """Let go of everything as a process does that is killed: nothing more is written."""
    os.close(document._journal._file)


@pytest.mark.parametrize("name", ["sorting.sym.xmi", "sorting.pnml", "one_topic.sym.xmi"])
def test_a_file_of_ours_is_saved_as_it_was(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    shutil.copy(ROOT / "case_study" / name, file)
    before = file.read_bytes()
    document = Document(file)
    assert document.save().data == before == file.read_bytes()
    net = document.root.pages[0]
    assert isinstance(net, sym.NodeNet)
    document.do([Move(handle(document, net.id), 12.5, 7)])
    assert document.content().data != before
    document.undo()
    assert document.content().data == before
    document.close()
    assert [each.name for each in tmp_path.iterdir()] == [name]


@pytest.mark.skipif(not FEATURES.exists(), reason="the model is not here")
def test_in_a_file_of_others_only_one_position_differs(tmp_path: Path) -> None:
    file = tmp_path / FEATURES.name
    shutil.copy(FEATURES, file)
    before = file.read_bytes()
    document = Document(file)
    document.do([Move(handle(document, "P2"), 1300, 520)])
    assert document.save().keeps_form
    assert changed_lines(before, file.read_bytes()) == [
        (
            b'        <graphics><position x="1286" y="511"/></graphics>',
            b'        <graphics><position x="1300" y="520"/></graphics>',
        )
    ]
    document.undo()
    document.save()
    assert file.read_bytes() == before
    document.close()


OTHERS = b"""<?xml version='1.0'?>
<!-- drawn by somebody else -->
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
<net id="n" type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="p">
   <place id='a'> <initialMarking><text> 2 </text></initialMarking>   <!-- two -->
     <toolspecific tool="other" version="3"><colour rgb = "#fff"> red &amp; blue</colour></toolspecific>
     <graphics><position y="7" x='3'/><fill color="#ffffff"/></graphics><name><text>A</text></name></place>
   <transition id="t"/>
   <arc source="a" id="x" target="t"/>
</page></net></pnml>"""


def test_what_somebody_else_wrote_stays_to_the_byte(tmp_path: Path) -> None:
    file = tmp_path / "net.pnml"

    def after(command: Callable[[Document], Command]) -> bytes:
        file.write_bytes(OTHERS)
        document = Document(file)
        document.do([command(document)])
        assert document.save().keeps_form
        document.close()
        return file.read_bytes()

    def a(document: Document) -> str:
        return handle(document, "a")

    assert after(lambda d: Move(a(d), 3, 8)) == OTHERS.replace(b'y="7"', b'y="8"')
    assert after(lambda d: Set(a(d), "tokens", 5)) == OTHERS.replace(b"<text> 2 </text>", b"<text>5</text>")
    assert after(lambda d: Set(a(d), "name", "B")) == OTHERS.replace(b"<text>A</text>", b"<text>B</text>")
    assert after(lambda d: Delete((handle(d, "x"),))) == OTHERS.replace(
        b'\n   <arc source="a" id="x" target="t"/>', b""
    )
    moved = after(lambda d: Move(handle(d, "t"), 1, 2))
    assert b"".join(map(bytes.strip, moved.splitlines())) == b"".join(
        map(
            bytes.strip,
            OTHERS.replace(
                b'<transition id="t"/>',
                b'<transition id="t"><graphics><position x="1" y="2"/></graphics></transition>',
            ).splitlines(),
        )
    )
    drawn = after(lambda d: Create(handle(d, "p"), "objects", "pn.Place", {"id": "b", "name": "<new>"}))
    assert OTHERS.partition(b'<transition id="t"/>')[0] in drawn
    assert b"drawn by somebody else" in drawn and b"<text>&lt;new&gt;</text>" in drawn
    assert find(load(file), "b").name == "<new>"


def test_a_killed_process_loses_nothing(tmp_path: Path) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    before = file.read_bytes()
    document = Document(file)
    document.do([Set(handle(document, "Words"), "tokens", 8)], "tokens", by=("tab", 1))
    document.do([Set(handle(document, "Button"), "name", "the button")])
    document.undo()
    document.do([Clause(handle(document, "Say"), "!Button")])
    wanted = document.content().data
    killed(document)
    with journal_of(file).open("ab") as stream:
        stream.write(b'{"do":[{"kind":"move"')  # it was killed while it wrote
    assert file.read_bytes() == before

    again = Document(file)
    assert again.recovered == 4 and not again.is_saved
    assert again.epoch == document.epoch  # a page that was cut off means the same elements
    assert again.content().data == wanted
    assert again.do([], by=("tab", 1)).touched == []  # confirmed before: not done twice
    again.undo()
    again.undo()
    assert again.content().data == before
    again.redo()
    again.redo()
    again.save()
    killed(again)

    third = Document(file)
    assert third.content().data == wanted == file.read_bytes()
    saved = [third.is_saved]
    third.undo()  # what was done before it was saved, too
    saved.append(third.is_saved)
    third.redo()
    assert [*saved, third.is_saved] == [True, False, True]
    third.close()
    assert not journal_of(file).exists()


def test_killed_between_writing_and_noting_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    document.do([Set(handle(document, "Words"), "tokens", 8)])
    monkeypatch.setattr(document, "_note_saved", lambda content: killed(document))
    document.save()
    again = Document(file)
    assert again.disk() == "same" and again.is_saved
    again.close()


def test_a_file_that_others_changed_is_not_written(tmp_path: Path) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    document.do([Set(handle(document, "Words"), "tokens", 8)])
    assert document.disk() == "same"
    other = talker()
    other.name = "by somebody else"
    save(other, file)
    theirs = file.read_bytes()
    assert document.disk() == "changed" and document.on_disk().name == "by somebody else"
    with pytest.raises(ModelFileError, match="was changed by another program or person"):
        document.save()
    assert file.read_bytes() == theirs
    epoch = document.epoch
    document.reload()
    assert document.root.name == "by somebody else" and document.epoch != epoch and document.is_saved
    document.do([Set(handle(document, "Words"), "tokens", 9)])
    file.unlink()
    assert document.disk() == "gone"
    document.save()  # nothing of anybody is overwritten
    save(other, file)
    document.save(over=True)
    assert find(load(file), "Words", pn.Place).tokens == 9
    document.close()


def test_nobody_else_edits_the_file_meanwhile(tmp_path: Path) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    with pytest.raises(JournalError, match="edited by another process"):
        Document(file)
    document.close()
    Document(file).close()


def test_a_new_model_begins_empty(tmp_path: Path) -> None:
    file = tmp_path / "a new one.sym.xmi"
    document = Document(file)
    assert (document.root.id, document.disk(), document.is_saved) == ("a_new_one", "new", False)
    document.close()
    assert list(tmp_path.iterdir()) == []  # nobody drew anything
    document = Document(file)
    root = document.handles.of(document.root)
    assert root is not None
    document.do([Create(root, "pages", "sym.NodeNet", {"id": "talker"})])
    document.close()
    document = Document(file)  # it was not saved, but is not lost
    assert [page.id for page in document.root.pages] == ["talker"]
    document.save()
    document.close()
    assert [page.id for page in load(file).pages] == ["talker"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b'{"do": "nothing"}\n', "a group is a list of commands"),
        (b'{"do": [{"kind": "delete", "elements": ["e0"]}]}\n', "the model itself cannot be deleted"),
        (b'{"redo": true}\n', "nothing to undo or redo"),
        (b"[[[[\n", "no JSON"),
        (b"7\n", "not an entry"),
        (b'{"what": 1}\n', "unknown kind"),
    ],
)
def test_a_journal_that_somebody_damaged_is_said(tmp_path: Path, line: bytes, said: str) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    document.do([Set(handle(document, "Words"), "tokens", 8)])
    killed(document)
    journal = journal_of(file)
    whole = journal.read_bytes()
    journal.write_bytes(whole + line)
    with pytest.raises(Exception, match=f"dineros-journal:3:? .*{said}|{said}"):
        Document(file)
    assert journal.read_bytes() == whole + line  # nothing is thrown away
    first = json.loads(whole.splitlines()[0])
    journal.write_bytes(json.dumps({**first, "base": "AAAA"}).encode() + b"\n")
    with pytest.raises(JournalError, match="does not hold the model with which it began"):
        Document(file)


def test_what_is_no_model_gets_no_journal(tmp_path: Path) -> None:
    file = tmp_path / "broken.sym.xmi"
    file.write_text("<no model")
    with pytest.raises(ModelFileError):
        Document(file)
    with pytest.raises(ModelFileError, match="not a suffix of a model that can be edited"):
        Document(tmp_path / "model.txt")
    assert [each.name for each in tmp_path.iterdir()] == ["broken.sym.xmi"]


def test_a_disk_that_is_full_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    before = document.content().data
    objects = len(list(subtree(document.root)))

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as context:
        context.setattr(os, "pwrite", full)
        for command in (Move(handle(document, "Words"), 1, 2), Delete((handle(document, "Words"),))):
            with pytest.raises(JournalError, match="No space left"):
                document.do([command])
    assert document.content().data == before and len(list(subtree(document.root))) == objects
    document.do([Move(handle(document, "Words"), 1, 2)])
    killed(document)
    assert Document(file).recovered == 1


def test_numbers_of_a_sender_only_grow(tmp_path: Path) -> None:
    document = Document(tmp_path / "new.sym.xmi")
    root = document.handles.of(document.root)
    assert root is not None
    first = document.do([Set(root, "name", "x")], by=("tab", 3))
    assert document.do([Set(root, "name", "y")], by=("tab", 3)).revision == first.revision
    with pytest.raises(CommandError, match="number 2 came after number 3"):
        document.do([Set(root, "name", "y")], by=("tab", 2))
    document.do([Set(root, "name", "z")], by=("other", 1))
    assert document.root.name == "z"
    document.close()


@settings(max_examples=15)
@given(random=st.randoms(use_true_random=False))
def test_whatever_changes_in_a_file_of_others_is_in_it(
    tmp_path_factory: pytest.TempPathFactory, random: Random
) -> None:
    file = tmp_path_factory.mktemp("others") / "net.pnml"
    file.write_bytes(OTHERS)
    document = Document(file)
    drawer = Drawer(document._editor, random)
    for _ in range(8):
        try:
            document.do(decode_commands(drawer.group(forged=0)))
            content = document.content()
        except DinerosError:  # what PNML cannot hold, such as fewer than no tokens, is not saved
            continue
        # Read from PNML, an arc between nodes of one page stands on that page.
        wanted = read_content(own_form(document.root, file), file)
        assert own_form(read_content(content.data, file), file) == own_form(wanted, file)
    while document.undo_label is not None:
        document.undo()
    assert document.save().data == OTHERS == file.read_bytes()
    document.close()
