"""What the editor takes from strangers: messages of pages, and journals that somebody damaged."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from dineros.metamodel.editing import Document
from dineros.metamodel.editing.journal import journal_of
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import save
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.views.editing.session import Session
from tests.fuzz.judging import Outcome
from tests.support.systems.talker import talker

Attempt = Callable[[bytes], Outcome]

COMMANDS = [
    {
        "kind": "create",
        "owner": "e1",
        "feature": "objects",
        "type": "sym.Place",
        "values": {"tokens": 2},
        "called": "$p",
    },
    {
        "kind": "create",
        "owner": "e1",
        "feature": "arcs",
        "type": "pn.Arc",
        "values": {"source": "e2", "target": "e3"},
    },
    {"kind": "set", "element": "e2", "feature": "tokens", "value": 5},
    {"kind": "set", "element": "e4", "feature": "name", "value": "a name"},
    {"kind": "delete", "elements": ["e2", "e3"]},
    {"kind": "place", "element": "e2", "owner": "e1", "feature": "objects", "index": 0},
    {"kind": "add", "element": "e3", "feature": "overrides", "target": "e3"},
    {"kind": "remove", "element": "e3", "feature": "overrides", "target": "e3"},
    {"kind": "move", "element": "e2", "x": 1.5, "y": -3},
    {"kind": "bend", "element": "e9", "points": [[1, 2], [3, 4]]},
    {"kind": "clause", "element": "e3", "text": "!Button | Button"},
]
OPERATIONS = [
    {"kind": "copy", "elements": ["e2", "e3"], "owner": "e1", "dx": 10, "dy": 10.5},
    {"kind": "into", "elements": ["e2"], "page": "e12"},
    {"kind": "group", "elements": ["e2", "e3"], "type": "sym.CallbackPage"},
    {"kind": "split", "page": "e12"},
    {"kind": "fill", "token": "e2", "field": "color", "text": "red"},
    {"kind": "insert", "template": "safety loop", "x": 100, "y": 50},
]
MESSAGES = [
    *(json.dumps({"number": 1, "ask": "compose", "operation": each}).encode() for each in OPERATIONS),
    b'{"number": 1, "ask": "clause", "element": "e3", "text": "Button & !Knob"}',
    *(json.dumps({"number": 1, "ask": "do", "commands": [each], "label": "x"}).encode() for each in COMMANDS),
    json.dumps({"number": 1, "ask": "do", "commands": COMMANDS}).encode(),
    *(json.dumps({"number": 1, "ask": ask}).encode() for ask in ("undo", "redo", "save", "reload")),
    b'{"number": 1, "ask": "save", "over": true}',
]


def editor(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Say something to an editor; the model must be one that can be saved afterwards."""
    file = folder / "drawn.sym.xmi"
    save(talker(), file)
    document = Document(file)
    ending.callback(document.close)
    session = Session(document)
    pages = iter(range(1 << 30))

    def attempt(content: bytes) -> Outcome:
        answer = session.hear(content, f"page {next(pages)}")
        (own,) = map(json.loads, answer.own)
        assert own["type"] in ("done", "refused") and "unexpected" not in own.get("reason", ""), own
        assert xmi_bytes(document.root)
        while document.undo_label is not None:
            document.undo()
        return Outcome(0 if own["type"] == "done" else 2, f"{own['type']}\n")

    return MESSAGES, attempt


def editors_journal(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Open a model whose journal was damaged."""
    file = folder / "kept.sym.xmi"
    save(talker(), file)
    document = Document(file)
    session = Session(document)
    for number, command in enumerate(COMMANDS, 1):
        session.hear(json.dumps({"number": number, "ask": "do", "commands": [command]}), "page")
    session.hear(b'{"number": 99, "ask": "undo"}', "page")
    seed = journal_of(file).read_bytes()
    document.close()

    def attempt(content: bytes) -> Outcome:
        journal_of(file).write_bytes(content)
        try:
            again = Document(file)
        except DinerosError as error:
            return Outcome(2, f"{error}\n")
        assert xmi_bytes(again.root)
        again.close()
        return Outcome(0, "opened\n")

    return [seed], attempt
