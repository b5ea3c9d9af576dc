"""Single commands: what they do, what goes with it, what is refused and why; each undone exactly."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import cnf_text
from dineros.metamodel.constraints import validate
from dineros.metamodel.editing import decode_commands, editor
from dineros.metamodel.editing.changes import undo
from dineros.metamodel.editing.commands import KINDS, encode_command
from dineros.metamodel.editing.editor import Editor
from dineros.metamodel.editing.naming import used_ids
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.xmi import xmi_bytes
from tests.support.systems.talker import talker


class Bench:
    """A model to try commands on, whose elements are called by their ids."""

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        self.editor = Editor(model)
        self.begin = xmi_bytes(model)
        self.done: list[Any] = []

    def handle(self, id: str) -> str:
        found = self.editor.handles.of(find(self.model, id))
        assert found is not None
        return found

    def do(self, *commands: dict[str, Any]) -> dict[str, str]:
        """Do commands; ``@ID`` stands for the handle of an element."""
        performed = self.editor.perform(decode_commands([self._named(each) for each in commands]))
        self.done.append(performed.changes)
        return performed.made

    def _named(self, value: Any) -> Any:
        if isinstance(value, dict):
            return {key: self._named(each) for key, each in value.items()}
        if isinstance(value, list):
            return [self._named(each) for each in value]
        return self.handle(value[1:]) if isinstance(value, str) and value.startswith("@") else value

    def ids(self) -> set[str]:
        return {each.id for each in self.model.eAllContents() if isinstance(each, pn.Element)}


@pytest.fixture
def bench() -> Iterator[Bench]:
    """Return a bench; at the end, undoing everything must give the first bytes."""
    found = Bench(talker())
    yield found
    for changes in reversed(found.done):
        undo(changes)
    assert xmi_bytes(found.model) == found.begin


def test_a_place_goes_with_its_arcs_and_ports(bench: Bench) -> None:
    bench.do({"kind": "delete", "elements": ["@Said"]})
    channel = find(bench.model, "Chatter", sym.TopicChannel)
    assert {"Words-Say", "Say"} <= bench.ids() and not bench.ids() & {"Said", "Say-Said"}
    assert len(channel.publishers) == 0 and len(channel.subscribers) == 1
    assert len(find(bench.model, "Say", sym.Transition).outgoing) == 0


def test_a_service_goes_with_the_place_its_server_needs(bench: Bench) -> None:
    place = {"kind": "create", "owner": "@listener", "feature": "objects", "type": "sym.Place"}
    bench.do(
        {"kind": "create", "owner": "@listener", "feature": "objects", "type": "pn.Page", "called": "$page"},
        {**place, "owner": "$page", "called": "$in"},
        {**place, "owner": "$page", "called": "$out"},
        {
            **{"kind": "create", "owner": "@greeting", "feature": "channels", "type": "sym.ServiceChannel"},
            **{"called": "$service", "values": {"id": "Ask", "service": "ask"}},
        },
        {
            **{"kind": "create", "owner": "$service", "feature": "server", "type": "sym.ServerPort"},
            "values": {"entry": "$in", "exit": "$out", "page": "$page"},
        },
        {"kind": "set", "element": "$in", "feature": "id", "value": "Asked"},
    )
    assert "Ask" in bench.ids()
    bench.do({"kind": "delete", "elements": ["@Asked"]})
    assert not bench.ids() & {"Ask", "Asked"}


def test_a_signal_is_renamed_in_all_clauses(bench: Bench) -> None:
    say = find(bench.model, "Say", sym.Transition)
    assert say.clause is not None
    bench.do({"kind": "clause", "element": "@Say", "text": 'Button & !( "Button" -> false )'})
    bench.do({"kind": "set", "element": "@Button", "feature": "name", "value": "red button"})
    assert say.clause.text == '"red button" & !( "red button" -> false )'
    assert cnf_text(say.clause) == '"red button"'
    assert validate(bench.model) == []
    bench.do({"kind": "set", "element": "@Button", "feature": "id", "value": "b"})  # its name stands for it
    assert say.clause.text == '"red button" & !( "red button" -> false )'
    bench.do({"kind": "set", "element": "@b", "feature": "name", "value": None})
    assert say.clause.text == "b & !( b -> false )"
    signal = {"kind": "create", "owner": "@talker", "feature": "signals", "type": "sym.InputSignal"}
    bench.do({**signal, "values": {"id": "c"}})
    with pytest.raises(DinerosError, match="has a signal 'c' already"):
        bench.do({"kind": "set", "element": "@b", "feature": "name", "value": "c"})


def test_a_token_field_is_renamed_in_data_and_mappings(bench: Bench) -> None:
    part = {"kind": "create", "owner": "$type", "feature": "fields", "type": "sym.TokenField"}
    bench.do(
        {
            "kind": "create",
            "owner": "@greeting",
            "feature": "tokenType",
            "type": "sym.TokenType",
            "called": "$type",
        },
        {**part, "called": "$field", "values": {"name": "colour"}},
        {
            **{"kind": "create", "owner": "@Words", "feature": "balloons", "type": "sym.BalloonToken"},
            "values": {"data": '{"other": 1, "colour": "red"}'},
        },
        {
            **{"kind": "create", "owner": "@Chatter", "feature": "mappings", "type": "sym.FieldMapping"},
            "values": {"messageField": "color", "tokenField": "colour"},
        },
        {"kind": "set", "element": "$field", "feature": "name", "value": "paint"},
    )
    assert find(bench.model, "Words", sym.Place).balloons[0].data == '{"other": 1, "paint": "red"}'
    assert find(bench.model, "Chatter", sym.TopicChannel).mappings[0].tokenField == "paint"


def test_lists_keep_their_order(bench: Bench) -> None:
    def order() -> list[str]:
        return [each.id for each in find(bench.model, "talker", sym.NodeNet).objects]

    assert order() == ["Words", "Say", "Said"]
    bench.do({"kind": "place", "element": "@Said", "owner": "@talker", "feature": "objects", "index": 0})
    assert order() == ["Said", "Words", "Say"]
    bench.do({"kind": "place", "element": "@Words", "owner": "@OnChatter", "feature": "objects", "index": 1})
    assert order() == ["Said", "Say"]
    assert find(bench.model, "Words", sym.Place).page is find(bench.model, "OnChatter")


def test_where_things_are_drawn(bench: Bench) -> None:
    bench.do({"kind": "move", "element": "@Words", "x": 3, "y": 4.5})
    bench.do({"kind": "bend", "element": "@Words-Say", "points": [[1, 2], [3, 4]]})
    graphics = find(bench.model, "Words-Say").graphics
    assert graphics is not None and [(each.x, each.y) for each in graphics.positions] == [(1, 2), (3, 4)]
    bench.do({"kind": "bend", "element": "@Words-Say", "points": []})
    assert find(bench.model, "Words-Say").graphics is None


NEW = {"kind": "create", "owner": "@talker", "feature": "objects", "type": "sym.Place"}
REFUSED: list[tuple[list[dict[str, Any]], str]] = [
    ([{"kind": "delete", "elements": ["@Button"]}], "the clause of transition 'Say' refers to input signal"),
    ([{"kind": "delete", "elements": ["@greeting"]}], "the model itself cannot be deleted"),
    ([{**NEW, "values": {"id": "Words"}}], "the id 'Words' is that of place 'Words' already"),
    ([{**NEW, "values": {"id": "a b"}}], "has white space"),
    ([{**NEW, "type": "rtm.Place"}], "an element of the class 'rtm.Place' cannot be created here"),
    ([{**NEW, "type": "pn.Place"}], "an element of the class 'pn.Place' cannot be created here"),
    ([{**NEW, "type": "sym.InputSignal"}], "cannot hold a sym.InputSignal"),
    ([{**NEW, "index": 9}], "has 3 elements, no place 9"),
    ([{**NEW, "feature": "arcs", "type": "pn.Arc"}], "needs source"),
    ([{**NEW, "feature": "arcs", "type": "pn.Arc", "values": {"source": "@Chatter"}}], "leads to a Node"),
    ([{**NEW, "called": "p"}], "not a new name that begins with"),
    (
        [{"kind": "set", "element": "@Words", "feature": "tokens", "value": "3"}],
        "tokens must be a whole number",
    ),
    (
        [{"kind": "set", "element": "@Words", "feature": "tokens", "value": True}],
        "tokens must be a whole number",
    ),
    ([{"kind": "set", "element": "@Words", "feature": "tokens", "value": 2**31}], "32 bits"),
    ([{"kind": "set", "element": "@Words", "feature": "kind", "value": "strat"}], "did you mean 'start'"),
    ([{"kind": "set", "element": "@Words", "feature": "name", "value": "a\x00"}], "which files cannot store"),
    (
        [{"kind": "set", "element": "@Words", "feature": "page", "value": None}],
        "cannot be changed by this command",
    ),
    ([{"kind": "set", "element": "@Words-Say", "feature": "source", "value": None}], "must have a target"),
    ([{"kind": "set", "element": "e999", "feature": "name", "value": "x"}], "no element has the handle"),
    ([{"kind": "set", "element": "$x", "feature": "name", "value": "x"}], "nothing in this group is called"),
    ([{"kind": "clause", "element": "@Say", "text": "Button & Knob"}], "has no signal 'Knob'"),
    ([{"kind": "clause", "element": "@Words", "text": "true"}], "has no clause"),
    (
        [{"kind": "place", "element": "@OnChatter", "owner": "@OnChatter", "feature": "objects"}],
        "into itself",
    ),
    ([{"kind": "place", "element": "@greeting", "owner": "@talker", "feature": "objects"}], "into itself"),
    ([{"kind": "move", "element": "@Words-Say", "x": 1, "y": 2}], "has no position"),
    ([{"kind": "bend", "element": "@Words", "points": []}], "has no bend points"),
    (
        [{"kind": "add", "element": "@Say", "feature": "overrides", "target": "@Words"}],
        "leads to a Transition",
    ),
    ([{"kind": "remove", "element": "@Say", "feature": "overrides", "target": "@Listen"}], "in a list"),
    (
        [
            NEW,
            {"kind": "delete", "elements": ["@Words"]},
            {"kind": "move", "element": "@Words", "x": 1, "y": 1},
        ],
        "deleted",
    ),
]


@pytest.mark.parametrize(("commands", "reason"), REFUSED, ids=[reason for _, reason in REFUSED])
def test_what_is_refused_changes_nothing(bench: Bench, commands: list[dict[str, Any]], reason: str) -> None:
    handles = len(bench.editor.handles)
    with pytest.raises(DinerosError) as refused:
        bench.do(*commands)
    assert reason in str(refused.value)
    assert xmi_bytes(bench.model) == bench.begin and len(bench.editor.handles) == handles


def test_every_kind_is_read_as_it_is_written() -> None:
    examples: list[dict[str, Any]] = [
        {
            "kind": "create",
            "owner": "e1",
            "feature": "f",
            "type": "t",
            "values": {"a": 1},
            "index": 2,
            "called": "$x",
        },
        {"kind": "delete", "elements": ["e1"]},
        {"kind": "set", "element": "e1", "feature": "f", "value": None},
        {"kind": "add", "element": "e1", "feature": "f", "target": "e2", "index": None},
        {"kind": "remove", "element": "e1", "feature": "f", "target": "e2"},
        {"kind": "place", "element": "e1", "owner": "e2", "feature": "f", "index": 3},
        {"kind": "move", "element": "e1", "x": 1.5, "y": 2.0},
        {"kind": "bend", "element": "e1", "points": [[1.0, 2.0]]},
        {"kind": "clause", "element": "e1", "text": "a & b"},
    ]
    assert {each["kind"] for each in examples} == set(KINDS)
    assert [encode_command(each) for each in decode_commands(examples)] == examples


def test_a_large_group_looks_for_its_ids_once(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """4 000 new arcs went through the whole model 4 000 times, for minutes."""
    looks = 0

    def counted(root: Any) -> set[str]:
        nonlocal looks
        looks += 1
        return used_ids(root)

    monkeypatch.setattr(editor, "used_ids", counted)
    container = find(bench.model, "Say").eContainer()
    assert container is not None
    page = bench.editor.handles.of(container)
    arc = {"kind": "create", "owner": page, "feature": "arcs", "type": "pn.Arc"}
    arcs = [{**arc, "values": {"source": "@Words", "target": "@Say"}}] * 200
    named = {"kind": "set", "element": "@Words", "feature": "id", "value": "Spoken"}
    before = len(list(bench.model.eAllContents()))
    bench.do(*arcs, named, *arcs[:1])
    assert looks == 2
    assert "Spoken-Say" in bench.ids()
    assert len(list(bench.model.eAllContents())) == before + 201
    made = [each.id for each in bench.model.eAllContents() if isinstance(each, pn.Arc)]
    assert len(made) == len(set(made))
