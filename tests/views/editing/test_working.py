"""Checks, questions, workspaces and runs that pages order: other processes do it, and end with the editor."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import click
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.cli.main import main
from dineros.metamodel.editing import CommandError
from dineros.metamodel.files import load, save
from dineros.views.editing.working.node_logs import MOST_BYTES, NodeLogs
from dineros.views.editing.working.orders import order_of
from tests.metamodel.editing.random_commands import NASTY
from tests.support.systems.talker import talker
from tests.views.editing.conftest import Edit
from tests.views.editing.pages import Tab

TEXTS = st.text(min_size=1, max_size=60)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a model whose publisher loses words: its queue has room for one."""
    model = talker()
    model.channels[0].publishers[0].limit = 1  # type: ignore[attr-defined]
    save(model, tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def until(tab: Tab, job: int, *states: str) -> dict[str, Any]:
    while True:
        message = tab.hear()
        if message["type"] == "job" and message["job"] == job and message["state"] in states:
            return message


def done(tab: Tab, **order: object) -> dict[str, Any]:
    answer = tab.ask("work", action="start", order=order)
    assert answer["type"] == "done", answer
    return until(tab, answer["job"], "done", "failed")


@pytest.mark.long
def test_a_check_tells_of_elements_and_its_witness_is_played(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab, Tab(handle, "tabtwotwo") as other:
        job = done(tab, kind="check")
        assert until(other, job["job"], "done")["result"] == job["result"]  # all pages are told
        lost = next(each for each in job["result"]["findings"] if each["rule"] == "queue-overflow")
        assert lost["elements"] == [tab.by_id("Chatter"), tab.by_id("Said")]
        game = tab.ask("play", action="open", job=job["job"], witness=lost["witness"])["game"]
        assert game["title"] == lost["message"]
        game = tab.ask("play", action="go", to=game["length"])["game"]
        losing = [each for each in game["firings"] if each["kind"] == "loss"]
        assert game["steps"][-1]["kind"] == "loss" or losing
        with Tab(handle, "tabthreee") as late:
            assert [each["job"] for each in late.said[0]["jobs"]] == [job["job"]]
        # Of the model as it is drawn, saved or not; of another one, it is played no more.
        limit = {"kind": "set", "element": tab.by_id("Words"), "feature": "tokens", "value": 1}
        tab.ask("do", commands=[limit])
        refused = tab.ask("play", action="open", job=job["job"], witness=lost["witness"])
        assert refused["type"] == "refused" and "tokens that differ" in refused["reason"]
        assert load(file).pages[0].objects[0].tokens == 3  # type: ignore[attr-defined]
        fixed = done(tab, kind="find", marking="Noted >= 2", signals="none")
        assert fixed["result"]["status"] == "unreachable" and fixed["revision"] == 1


@pytest.mark.long
def test_wrong_questions_say_why_and_long_ones_are_cancelled(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab:
        wrong = done(tab, kind="verify", ltl="G (Nted <= 1)")
        assert wrong["state"] == "failed" and "did you mean 'Noted'" in wrong["log"][-1]
        begun = tab.ask("work", action="start", order={"kind": "run", "how": "local", "timeout": 600})
        again = tab.ask("work", action="start", order={"kind": "run", "how": "local", "timeout": 600})
        assert again["job"] == begun["job"]
        while not any("follow it" in line for line in until(tab, begun["job"], "running")["log"]):
            pass
        tab.ask("work", action="cancel", job=begun["job"])
        ended = until(tab, begun["job"], "cancelled")["result"]
        assert ended.get("ending", "interrupted") == "interrupted"  # it may not have got so far


def test_nothing_outlives_the_editor(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab:
        job = tab.ask("work", action="start", order={"kind": "run", "how": "local", "timeout": 600})["job"]
        while not any("follow it" in line for line in until(tab, job, "running")["log"]):
            pass
    mine = str(os.getpid())

    def children() -> list[str]:
        found = []
        for folder in Path("/proc").iterdir():
            if folder.name.isdigit():
                try:
                    words = (folder / "stat").read_text().rpartition(")")[2].split()
                    command = (folder / "cmdline").read_text()
                except OSError:
                    continue
                if words[1] == mine and str(file) in command and words[0] != "Z":
                    found.append(folder.name)
        return found

    assert len(children()) == 1
    handle.stop()
    for _ in range(100):
        if not children():
            break
        time.sleep(0.1)
    assert children() == []


@pytest.mark.long
def test_what_is_generated_is_shown_first_and_of_the_file(file: Path, edit: Edit) -> None:
    _, handle = edit(file)
    with Tab(handle, "taboneone") as tab:
        shown = done(tab, kind="generate", workspace="space")
        assert shown["result"]["stale"] and not (file.parent / "space").exists()
        written = done(tab, kind="generate", workspace="space", write=True)
        assert written["result"]["written"]
        assert (file.parent / "space/src/talker/package.xml").is_file()
        tab.ask(
            "do", commands=[{"kind": "set", "element": tab.by_id("Words"), "feature": "tokens", "value": 1}]
        )
        refused = tab.ask("work", action="start", order={"kind": "generate", "workspace": "space"})
        assert refused["reason"] == "the model is not saved"


def test_workspaces_are_run_on_ros_and_lie_beside_the_model(tmp_path: Path) -> None:
    order = order_of({"kind": "run", "how": "ros", "workspace": "spaces/one"}, tmp_path)
    line = order.line(tmp_path / "talker.sym.xmi", tmp_path / "kept")
    assert line[:2] == ["run", str(tmp_path / "spaces/one")] and "--local" not in line
    for wrong in ({"how": "ros", "workspace": "../one"}, {"how": "local", "workspace": "one"}):
        with pytest.raises(CommandError, match="workspace"):
            order_of({"kind": "run", **wrong}, tmp_path)


def test_what_nodes_print_is_taken_line_by_line(tmp_path: Path) -> None:
    logs = NodeLogs(tmp_path / "traces")
    assert logs.new_lines() == []
    (tmp_path / "traces").mkdir()
    talker, listener = (tmp_path / f"traces/{name}.log" for name in ("talker", "listener"))
    talker.write_bytes(b"one\ntw")
    listener.write_bytes(b"\xff\n")
    (tmp_path / "traces/supervisor.log.jsonl").write_text("{}\n")
    assert logs.new_lines() == ["listener: \ufffd", "talker: one"]
    assert logs.new_lines() == []
    with talker.open("ab") as log:
        log.write(b"o\n")
    assert logs.new_lines() == ["talker: two"]
    with talker.open("ab") as log:
        log.write(b"0123456\n" * (MOST_BYTES // 4))  # twice as much as is read at a time
    found = logs.new_lines()
    assert found[0] == f"talker: … {MOST_BYTES:,} bytes more" and set(found[1:]) == {"talker: 0123456"}
    assert logs.new_lines() == []


def test_an_editor_without_a_program_says_so(file: Path) -> None:
    from dineros.metamodel.editing import Document
    from dineros.views.editing.session import Session

    document = Document(file)
    try:
        answer = Session(document).hear('{"number":1,"ask":"work","action":"start","order":{}}', "abcdefgh")
        assert "this editor cannot run commands" in answer.own[0]
    finally:
        document.close()


@given(TEXTS, st.sampled_from(["marking", "enabled", "ltl", "ctl"]))
def test_whatever_a_question_says_is_one_argument(text: str, which: str) -> None:
    kind = "find" if which in ("marking", "enabled") else "verify"
    try:
        order = order_of({"kind": kind, which: text}, Path("/tmp"))
    except CommandError:
        return
    line = order.line(Path("model.sym.xmi"), Path("folder"))
    command = main.get_command(click.Context(main), kind)
    assert command is not None
    params: dict[str, Any] = {}
    command.make_parser(click.Context(command))
    parsed, rest, _ = command.make_parser(click.Context(command)).parse_args(list(line[1:]))
    params.update(parsed)
    assert params[which] == text
    assert params["output"] == "folder/witness.jsonl" and rest == []


@given(
    st.dictionaries(
        st.sampled_from(
            ["kind", "marking", "ltl", "signals", "timeout", "workspace", "write", "how", "until"]
        ),
        st.sampled_from(NASTY)
        | st.sampled_from(
            ["check", "find", "generate", "run", "../x", "/etc", "-o", "simulate", 0, -1, 1e9, True]
        ),
    )
)
@settings(max_examples=200)
def test_forged_orders_are_refused_or_harmless(said: dict[str, Any]) -> None:
    try:
        order = order_of(said, Path("/models"))
    except CommandError:
        return
    if order.kind == "generate":
        assert Path(order.arguments[1]).parent.is_relative_to("/models")
        assert ".." not in order.arguments[1]
    assert not any("\0" in each for each in order.arguments)
