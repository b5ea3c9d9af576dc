"""Token games without a browser: the net that is proved fires, and is shown on the model."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.model.subject import subject_of
from dineros.analysis.witnesses.records import witness_records
from dineros.analysis.witnesses.witness import witness_of
from dineros.metamodel import pn
from dineros.metamodel.editing import Document
from dineros.metamodel.editing.commands import Set
from dineros.metamodel.files import load, save
from dineros.metamodel.records import encode_record
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal.recorder import JournalRecorder
from dineros.transformations.flattening.split import split
from dineros.views.editing.session import Session
from dineros.views.traces.reading import build
from tests.metamodel.editing.random_commands import NASTY
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


class Player:
    """A page that plays, without a server."""

    def __init__(self, file: Path) -> None:
        self.document = Document(file)
        self.session = Session(self.document)
        self.session.playing._draw = Random(7)
        self._number = 0

    def ask(self, **said: object) -> dict[str, Any]:
        self._number += 1
        text = json.dumps({"number": self._number, "ask": "play", **said})
        (answer,) = self.session.hear(text, "abcdefgh").own
        found: dict[str, Any] = json.loads(answer)
        return found

    def game(self, **said: object) -> dict[str, Any]:
        answer = self.ask(**said)
        assert answer["type"] == "done", answer
        found: dict[str, Any] = answer["game"]
        return found

    def refused(self, **said: object) -> str:
        answer = self.ask(**said)
        assert answer["type"] == "refused"
        return str(answer["reason"])

    def handle(self, id: str) -> str:
        element = next(each for each in self.document.root.eAllContents() if getattr(each, "id", None) == id)
        found = self.document.handles.of(element)
        assert found is not None
        return found


@pytest.fixture
def player(tmp_path: Path) -> Iterator[Player]:
    save(talker(), tmp_path / "talker.sym.xmi")
    found = Player(tmp_path / "talker.sym.xmi")
    yield found
    found.document.close()


def test_a_message_goes_from_place_to_queue_to_place(player: Player) -> None:
    game = player.game(action="begin", signals="fully-enabled")
    words, noted, chatter, button = map(player.handle, ("Words", "Noted", "Chatter", "Button"))
    assert game["places"][words] == 3 and game["signals"] == {button: False}
    assert [each["kind"] for each in game["firings"]] == ["signal"]
    game = player.game(action="fire", transition="Button.toTrue", at=0)
    assert game["signals"] == {button: True}
    assert {"id": "Say", "text": "Say", "kind": "fire", "elements": [player.handle("Say")]} in game["firings"]
    game = player.game(action="fire", transition="Say", at=1)
    enter = next(each for each in game["firings"] if each["kind"] == "channel")
    assert enter["elements"] == [chatter, player.handle("Said")]
    game = player.game(action="fire", transition=enter["id"], at=2)
    assert game["queues"][chatter][0] == {"text": "publisher Said", "load": 1, "room": 9}
    back = player.game(action="go", to=1)
    assert back["places"][words] == 3 and back["length"] == 3
    ahead = player.game(action="go", to=3)
    assert ahead == game
    # What comes twice is done once; another step forgets what was to come.
    assert player.game(action="fire", transition="Say", at=1) == game
    player.game(action="go", to=1)
    other = player.game(action="fire", transition="Button.toFalse", at=1)
    assert other["length"] == 2
    end = player.game(action="wander", count=1000, at=2)
    assert end["places"][noted] == 3


def test_games_are_runs_of_the_flattened_net(player: Player) -> None:
    """Differential: what the game shows is what the plain firing rule gives."""
    player.game(action="begin", signals="input-enabled")
    game = player.game(action="wander", count=40, at=0)
    subject = subject_of(load(player.document.path), "input-enabled")
    marking = subject.net.initial.tolist()
    for step in game["steps"]:
        marking = subject.net.fire(subject.transition_index[step["id"]], marking)
    for id in ("Words", "Said", "Heard", "Noted"):
        assert game["places"][player.handle(id)] == marking[subject.place_index[id]]
    enabled = {
        name for name, index in subject.transition_index.items() if subject.net.is_enabled(index, marking)
    }
    assert {each["id"] for each in game["firings"]} == enabled


@pytest.mark.long
def test_copies_of_server_instances_are_added_up(tmp_path: Path) -> None:
    (tmp_path / CASE_STUDY.name).write_bytes(CASE_STUDY.read_bytes())
    player = Player(tmp_path / CASE_STUDY.name)
    try:
        player.game(action="begin", signals="fully-enabled")
        net = subject_of(load(CASE_STUDY), "fully-enabled").net
        copies = defaultdict(list)
        for index, name in enumerate(net.places):
            if match := re.fullmatch(r"\w+\[\d\]\.(\w+)", name):
                copies[match[1]].append(index)
        differ = 0
        for at in range(0, 300, 10):
            game = player.game(action="wander", count=10, at=at)
            marking = player.session.playing._tables["abcdefgh"].game.marking
            for place, both in copies.items():
                if len(both) == 2:
                    assert game["places"][player.handle(place)] == marking[both[0]] + marking[both[1]]
                    differ += marking[both[0]] > marking[both[1]]
        assert differ > 0
        assert any("of server instance" in each["text"] for each in game["steps"])
        assert all(each["elements"] for each in game["steps"])
    finally:
        player.document.close()


def test_a_game_is_a_trace_that_is_drawn_and_played_again(player: Player, tmp_path: Path) -> None:
    player.game(action="begin", signals="fully-enabled")
    played = player.game(action="wander", count=9, at=0)
    trace = player.session.playing.trace("abcdefgh")
    (tmp_path / "game.jsonl").write_text(trace, encoding="utf-8")
    builder = build([tmp_path / "game.jsonl"], load(player.document.path))
    assert [step.text for step in builder.steps] == [step["text"] for step in played["steps"]]
    again = player.game(action="open", traces={"game.jsonl": trace})
    assert (again["at"], again["length"], again["title"]) == (0, 9, "game.jsonl")
    end = player.game(action="go", to=9)
    assert end["places"] == played["places"]


@pytest.mark.parametrize("signals", ["none", "input-enabled"])
def test_a_witness_is_played(player: Player, signals: Any) -> None:
    subject = subject_of(load(player.document.path), signals)
    net, draw, steps = subject.net, Random(3), list[int]()
    marking, noted = net.initial.tolist(), subject.place_index["Noted"]
    while marking[noted] < 2:
        enabled = [each for each in range(len(net.transitions)) if net.is_enabled(each, marking)]
        steps.append(draw.choice(enabled))
        marking = net.fire(steps[-1], marking)
    witness = witness_of(subject, steps)
    records = witness_records(witness, source="talker.sym.xmi", asked="Noted >= 2", verdict="reachable")
    text = "".join(f"{encode_record(each)}\n" for each in records)
    game = player.game(action="open", traces={"witness.jsonl": text})
    assert game["title"] == "Noted >= 2"
    game = player.game(action="go", to=game["length"])
    assert game["places"][player.handle("Noted")] == 2


def test_a_recorded_run_is_played_as_it_conforms(tmp_path: Path) -> None:
    model = talker()
    model.pages[0].signals[0].initial = True  # type: ignore[attr-defined]
    save(model, tmp_path / "talker.sym.xmi")
    folder = tmp_path / "traces"

    def recorder(node: str) -> JournalRecorder:
        return JournalRecorder(folder, node)

    application = LocalApplication(split(model), seed=1, recorder=recorder)
    application.open()
    try:
        assert application.run(lambda each: each.count("listener", "Noted") == 3) == "reached"
    finally:
        application.close()
    traces = {each.name: each.read_text(encoding="utf-8") for each in folder.glob("*.jsonl")}
    player = Player(tmp_path / "talker.sym.xmi")
    try:
        game = player.game(action="open", traces=traces)
        assert game["title"].startswith("run of ") and "not allowed" not in game["title"]
        game = player.game(action="go", to=game["length"])
        assert game["places"][player.handle("Noted")] == 3
        assert {"Say", "Listen"} <= {each["id"] for each in game["steps"]}
        wrong = {name: text.replace('"Words":-1', '"Said":-1') for name, text in traces.items()}
        wrong = {name: re.sub(r',"crc":"[0-9a-f]{8}"', "", text) for name, text in wrong.items()}
        del wrong["listener.jsonl"]
        assert player.ask(action="open", traces=wrong)["type"] == "done"
        assert "is not a trace" in player.refused(action="open", traces={"a": ""})
    finally:
        player.document.close()


def test_another_model_ends_the_game(player: Player) -> None:
    player.game(action="begin", signals="fully-enabled")
    words = player.handle("Words")
    player.document.do([Set(words, "tokens", 5)])
    assert "changed" in player.refused(action="go", to=0)
    assert player.game(action="begin", signals="fully-enabled")["places"][words] == 5
    player.document.undo()
    trace = '{"sequence":0,"event":"header","schema":1,"kind":"witness","model":"greeting"}\n'
    assert "tokens that differ" in player.refused(action="open", traces={"t": trace})
    assert "trace of the model" in player.refused(action="open", traces={"t": trace.replace("greeting", "x")})


def test_models_with_errors_and_plain_nets(tmp_path: Path) -> None:
    model = talker()
    model.pages[0].objects[0].tokens = -1  # type: ignore[attr-defined]
    save(model, tmp_path / "wrong.sym.xmi")
    player = Player(tmp_path / "wrong.sym.xmi")
    assert "error" in player.refused(action="begin", signals="fully-enabled")
    player.document.close()
    place, go = pn.Place(id="a", tokens=1), pn.Transition(id="go")
    page = pn.Page(id="page", objects=[place, go], arcs=[pn.Arc(id="arc", source=place, target=go)])
    save(pn.Net(id="plain", pages=[page]), tmp_path / "plain.pnml")
    player = Player(tmp_path / "plain.pnml")
    game = player.game(action="begin", signals="fully-enabled")
    game = player.game(action="fire", transition=game["firings"][0]["id"], at=0)
    assert game["places"] == {player.handle("a"): 0} and game["firings"] == []
    player.document.close()


_WRONG = st.dictionaries(
    st.sampled_from(["action", "at", "to", "transition", "count", "signals", "traces", "x"]),
    st.sampled_from(NASTY)
    | st.sampled_from(["begin", "open", "fire", "go", "wander", "end", "Say", 0, 1, {"t": "{}"}]),
)


@pytest.mark.long
@given(st.lists(_WRONG, max_size=12))
@settings(max_examples=20, deadline=None)
def test_what_strangers_say_breaks_no_game(tmp_path_factory: pytest.TempPathFactory, said: list[Any]) -> None:
    file = tmp_path_factory.mktemp("game") / "talker.sym.xmi"
    save(talker(), file)
    player = Player(file)
    try:
        player.game(action="begin", signals="fully-enabled")
        for each in said:
            answer = player.ask(**each)
            assert answer["type"] in ("done", "refused")
            assert "unexpected" not in answer.get("reason", ""), answer
        assert player.game(action="begin", signals="fully-enabled")["at"] == 0
    finally:
        player.document.close()
