"""The editor's server, without a browser: who may come in, tabs, wrong things, a file that others change."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from dineros.metamodel import pn
from dineros.metamodel.editing import Document
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.views.editing.contents import model_json
from dineros.views.editing.description import description_for
from dineros.views.editing.session import Session
from tests.metamodel.editing.random_commands import NASTY, Drawer
from tests.support.systems.talker import talker
from tests.views.editing.conftest import Edit
from tests.views.editing.pages import PageModel, Tab

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save(talker(), tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def status(url: str, **headers: str) -> int:
    try:
        with urlopen(Request(url, headers=headers), timeout=20) as answer:
            return int(answer.status)
    except HTTPError as error:
        return error.code


def test_only_those_with_the_token_come_in(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    base, token = handle.url.split("/?token=")
    assert status(handle.url) == 200
    for path in ("/", "/compare", "/arrange"):
        assert status(f"{base}{path}") == 403
        assert status(f"{base}{path}?token={token[:-1]}") == 403
        assert status(f"{base}{path}?token={token}", Host="evil.example") == 403
    assert status(f"{base}/talker.sym.xmi?token={token}") == 404
    stream = f"{base.replace('http', 'ws')}/commands?tab=abcdefgh&token="

    def begins(url: str, origin: str | None) -> str:
        with connect(url, origin=origin) as socket:  # type: ignore[arg-type]
            try:
                return str(json.loads(socket.recv(timeout=10))["type"])
            except ConnectionClosed as closed:
                assert closed.rcvd is not None
                return str(closed.rcvd.code)

    assert begins(stream + token, base) == "snapshot"
    assert begins(f"{stream}wrong", base) == "4403"
    assert begins(stream + token, "http://evil.example") == "4403"
    assert begins(stream + token, None) == "4403"
    assert begins(f"{stream}{token}".replace("abcdefgh", "../.."), base) == "4408"


def test_two_tabs_stay_equal(file: Path, edit: Edit) -> None:
    document, handle = edit(file)
    with Tab(handle, "taboneone") as one, Tab(handle, "tabtwotwo") as two:
        words, page = one.by_id("Words"), one.by_id("talker")
        made = one.ask(
            "do",
            label="a place",
            commands=[
                {"kind": "create", "owner": page, "feature": "objects", "type": "sym.Place", "called": "$p"},
                {"kind": "move", "element": "$p", "x": 40, "y": 50},
            ],
        )
        assert made["type"] == "done"
        two.catch_up(1)
        assert made["made"]["$p"] in two.model["objects"]
        two.ask("do", commands=[{"kind": "delete", "elements": [words]}])
        one.catch_up(2)
        assert words not in one.model["objects"] and one.state["saved"] is False
        refused = one.ask("do", commands=[{"kind": "move", "element": words, "x": 0, "y": 0}])
        assert refused["type"] == "refused" and refused["reason"] == "place 'Words' was deleted"
        assert one.ask("undo")["type"] == "done"
        two.catch_up(3)
        assert words in two.model["objects"]
        two.ask("redo")
        two.ask("undo")
        one.catch_up(5)
        assert one.ask("save")["keepsForm"] is True
        while not two.state["saved"]:
            two.hear()
        assert one.model == two.model == json.loads(json.dumps(model_json(document)))
        assert one.marks == two.marks
    assert any(isinstance(each, pn.Place) and each.graphics is not None for each in subtree(load(file)))


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ("", "no JSON"),
        ("[[[[", "no JSON"),
        ("[]", "a message must be an object"),
        ('{"number": 0, "ask": "undo"}', "must have a number of 1 or more"),
        ('{"number": 1, "ask": "format the disk"}', "a request must be one of"),
        ('{"number": 1, "ask": "undo", "path": "/etc/passwd"}', "no field"),
        ('{"number": 1, "ask": "undo"}', "nothing to undo"),
        ('{"number": 1, "ask": "undo", "epoch": "of another file"}', "reloaded"),
        ('{"number": 1, "ask": "do"}', "list of commands"),
        ('{"number": 1, "ask": "do", "commands": [{"kind": "move"}]}', "move needs element"),
        (
            '{"number": 1, "ask": "do", "commands": '
            '[{"kind": "set", "element": "e0", "feature": "__class__", "value": 1}]}',
            "no feature",
        ),
        (
            '{"number": 1, "ask": "do", "commands": [{"kind": "delete", "elements": ["e0"]}]}',
            "cannot be deleted",
        ),
        ('{"number": 1, "ask": "save", "over": "yes"}', "true or false"),
    ],
)
def test_wrong_things_are_refused_with_a_reason(file: Path, said: str, reason: str) -> None:
    document = Document(file)
    session, before = Session(document), document.content().data
    answer = session.hear(said, "tab")
    (own,) = map(json.loads, answer.own)
    assert own["type"] == "refused" and reason in own["reason"] and answer.all == []
    assert document.content().data == before == file.read_bytes()
    document.close()


def test_a_message_that_is_too_long_ends_its_page_only(file: Path, edit: Edit) -> None:
    document, handle = edit(file)
    with Tab(handle, "tabonelong") as long, Tab(handle, "tabtwogood") as good:
        long.send("x" * ((1 << 20) + 1))
        with pytest.raises(ConnectionClosed):
            long.hear()
        assert (
            good.ask("do", commands=[{"kind": "set", "element": "e0", "feature": "name", "value": "n"}])[
                "type"
            ]
            == "done"
        )
        good.send(b"\xff\x00")
        assert good.answer(None)["type"] == "refused"
    assert document.root.name == "n"


@settings(max_examples=10)
@given(random=st.randoms(use_true_random=False))
def test_streams_of_messages_never_break_anything(
    tmp_path_factory: pytest.TempPathFactory, random: Random
) -> None:
    file = tmp_path_factory.mktemp("fuzz") / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    session, page = Session(document), PageModel()
    page.told(session.greeting())
    drawer = Drawer(document._editor, random)
    for number in range(1, 25):
        message = {"number": number, "ask": random.choice(("do", "do", "do", "do", "undo", "redo", "save"))}
        if message["ask"] == "do":
            message["commands"] = drawer.group()
        if random.random() < 0.1:
            message[random.choice(list(message))] = random.choice(NASTY)
        answer = session.hear(json.dumps(message), "tab")
        (own,) = map(json.loads, answer.own)
        assert own["type"] in ("done", "refused")
        assert "unexpected" not in own.get("reason", "")
        for text in answer.all:
            page.told(text)
    assert page.model == json.loads(json.dumps(model_json(document)))
    assert xmi_bytes(document.root)
    document.close()


def test_a_file_that_others_change_is_noticed_and_compared(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab:
        tab.ask(
            "do", commands=[{"kind": "set", "element": tab.by_id("Words"), "feature": "tokens", "value": 9}]
        )
        other = talker()
        find(other, "Said").name = "was said"
        save(other, file)
        while tab.state["disk"] != "changed":
            tab.hear()
        refused = tab.ask("save")
        assert "was changed by another program or person" in refused["reason"]
        with urlopen(handle.url.replace("/?", "/compare?"), timeout=60) as answer:
            page = answer.read().decode()
        assert "was said" in page and '"change":"changed"' in page
        assert tab.ask("reload")["type"] == "done"
        assert tab.revision == 0 and tab.state["saved"] is True
        names = [each.get("values", {}).get("name") for each in tab.model["objects"].values()]
        assert "was said" in names
        tab.ask("do", commands=[{"kind": "set", "element": "e0", "feature": "name", "value": "mine"}])
        save(talker(), file)
        while tab.state["disk"] != "changed":
            tab.hear()
        assert tab.ask("save", over=True)["type"] == "done"
    assert load(file).name == "mine"


def test_the_case_study_has_its_marks_with_each_answer(tmp_path: Path) -> None:
    file = tmp_path / CASE_STUDY.name
    file.write_bytes(CASE_STUDY.read_bytes())
    document = Document(file)
    session, page = Session(document), PageModel()
    page.told(session.greeting())
    place = page.by_id("RedObjects")
    before = page.model["objects"][place]["values"]["tokens"]
    for number in range(1, 21):
        tokens = -number if number < 5 else before + number % 2
        message = {"kind": "set", "element": place, "feature": "tokens", "value": tokens}
        answer = session.hear(json.dumps({"number": number, "ask": "do", "commands": [message]}), "tab")
        late = session.new_marks()  # as the server asks for, in a pause, where checking takes long
        for text in (*answer.all, *filter(None, [late])):
            page.told(text)
        assert (page.marks["errors"] > 0) is (number < 5)
        if number == 1:
            marks = [each for each in page.marks["marks"] if each["at"] == place]
            assert marks and all(each["fix"] and each["severity"] == "error" for each in marks)
    document.close()


def test_everything_that_can_be_made_on_a_sheet_has_a_shape() -> None:
    classes = description_for(talker())["classes"]
    drawn = {name for name, each in classes.items() if each["made"] and "shape" in each}
    sheets = {"pn.PageObject", "sym.Channel"}
    assert drawn == {name for name, each in classes.items() if each["made"] and sheets & set(each["supers"])}
    lines = {name: each for name, each in classes.items() if "lines" in each}
    assert {"pn.Arc", "sym.PublisherPort", "sym.ActionServerPort"} <= set(lines)
    for each in lines.values():
        known = {"in", "self", *(feature["name"] for feature in each["features"])}
        assert all({line["from"], line["to"]} <= known for line in each["lines"])
    assert all(each["says"] for each in classes.values())


def test_what_no_editor_put_anywhere_gets_a_place(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab:
        for sheet, wanted in (
            ("greeting", {"talker", "listener", "Chatter"}),
            ("talker", {"Words", "Say", "Said"}),
        ):
            address = handle.url.replace("/?", "/arrange?") + f"&sheet={tab.by_id(sheet)}"
            with urlopen(address, timeout=60) as answer:
                found = json.loads(answer.read())["positions"]
            assert set(found) == {tab.by_id(id) for id in wanted}
            assert len({tuple(each) for each in found.values()}) == len(wanted)
        assert status(handle.url.replace("/?", "/arrange?") + "&sheet=e99999") == 409
