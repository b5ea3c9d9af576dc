"""The command `conform`: verdicts, exit statuses, where traces come from, wrong use."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from dineros.metamodel.records import (
    Fire,
    Header,
    Record,
    Transfer,
    current_path,
    read_records,
    write_records,
)
from dineros.observation.explaining import midway
from tests.cli.conftest import Run
from tests.observation.explaining.test_silences import MAPS, ONCE, robot, until
from tests.observation.measuring.camera import KnownRun, camera
from tests.support.programs.bags import write_bag
from tests.support.programs.commands import is_one_line_of_wrong_use, lines, uses
from tests.support.references.runs import ReferenceRun
from tests.support.systems.talker import talker


def write(folder: Path, records: dict[str, list[Record]]) -> Path:
    folder.mkdir(exist_ok=True)
    for node, trace in records.items():
        numbered = [replace(record, sequence=number) for number, record in enumerate(trace)]
        write_records(current_path(folder, node), numbered)
    return folder


def records() -> dict[str, list[Record]]:
    return ReferenceRun(talker(), 1).run(60).stop().records


@pytest.fixture
def traces(tmp_path: Path) -> Path:
    return write(tmp_path / "run", records())


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    """Return traces in which the listener hears a word twice."""
    wrong = records()
    trace = wrong["listener"]
    position = next(number for number, record in enumerate(trace) if isinstance(record, Fire))
    trace.insert(position, trace[position])
    return write(tmp_path / "bad", wrong)


@pytest.mark.parametrize("format", ["text", "json", "sarif", "junit"])
def test_a_declared_time_that_a_run_breaks(run: Run, tmp_path: Path, format: str) -> None:
    known = KnownRun(1)
    path, traces = tmp_path / "camera.sym.xmi", write(tmp_path / "run", known.records)
    save(camera(), path)
    worst, count = max(known.durations), sum(each > 0.025 for each in known.durations)
    result = run("conform", path, traces, "--format", format)
    assert result.exit_code == 1, result.output
    said = f"callback OnImage took {worst * 1e3:.3g} ms at"
    assert said in result.stdout
    assert f"; declared: at most 20 ms ({count} of {len(known.durations)})" in result.stdout
    if format == "json":
        found = json.loads(result.stdout)
        assert found["status"] == "violated"
        assert "OnImage" in [each["element"] for each in found["times"]["violations"]]
    if format == "sarif":
        results = json.loads(result.stdout)["runs"][0]["results"]
        assert "duration-too-long" in {each["ruleId"] for each in results}
        assert all("region" in each["locations"][0]["physicalLocation"] for each in results)
    assert run("conform", path, traces, "--allowance", 1, "--format", format).exit_code == 0


def bag(folder: Path, words: int) -> Path:
    """Return a recording of what the talker says; it has three words to say."""
    return write_bag(folder, [("/chatter", 10**8 * number) for number in range(words)])


def test_a_recording_that_conforms(run: Run, model: Path, tmp_path: Path) -> None:
    result = run("conform", model, "--bag", bag(tmp_path / "bag", 3))
    assert result.exit_code == 0
    assert lines(result) == [f"{model}: conforms; 3 messages explained"]


def test_a_recording_with_a_message_too_many(run: Run, model: Path, tmp_path: Path) -> None:
    """It is named, and a run before it is written, which can be drawn."""
    recording, why = bag(tmp_path / "bag", 4), tmp_path / "why.jsonl"
    result = run("conform", model, "--bag", recording, "-o", why)
    assert result.exit_code == 1
    first = f"{model}: message 4, on /chatter, 0.300 s after the first: no run of the model explains it"
    assert result.stdout.startswith(first)
    header, *steps = read_records(why)
    assert isinstance(header, Header) and header.verdict == "violated"
    assert len([step for step in steps if isinstance(step, Transfer) and step.stage == "transport"]) == 3
    assert run("trace", why, "-o", tmp_path / "why.svg").exit_code == 0
    report = json.loads(run("conform", model, "--bag", recording, "--json").stdout)
    assert (report["status"], report["messages"], report["unexplained"]["number"]) == ("violated", 3, 4)


def test_a_topic_that_falls_silent_is_a_finding(run: Run, tmp_path: Path) -> None:
    model = tmp_path / "robot.sym.xmi"
    save(robot(ONCE), model)
    recording = write_bag(tmp_path / "bag", until(scan=10.0, ticks=29.0))
    said = f"{model}: nothing on /scan for 19.1 s; until then every 0.5 s; the model must continue"
    result = run("conform", model, "--bag", recording)
    assert (result.exit_code, lines(result)) == (1, [said, f"{model}: violated; 80 messages explained"])
    report = json.loads(run("conform", model, "--bag", recording, "--json").stdout)
    assert report["silences"] == [{"topic": "/scan", "seconds": 19.1, "every": 0.5}]


def test_what_midway_cannot_tell_is_said(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = tmp_path / "robot.sym.xmi"
    save(robot(ONCE, MAPS), model)
    recording = write_bag(tmp_path / "bag", until(scan=2.0, map=2.0))
    exact = run("conform", model, "--bag", recording, "--midway")
    assert exact.exit_code == 0
    assert "in any reachable state; how it is reached is not checked" in exact.stderr
    monkeypatch.setattr(midway, "WHOLE_NODES", 0)
    parts = run("conform", model, "--bag", recording, "--midway")
    assert parts.exit_code == 0
    assert "--midway cannot check that the initial states of the nodes agree" in parts.stderr
    assert "sent before on /scan; so it may accept recordings that the model does not allow" in parts.stderr


def test_what_was_recorded_and_what_was_not_is_said(run: Run, model: Path, tmp_path: Path) -> None:
    recording = write_bag(tmp_path / "bag", [("/chatter", 0), ("/elsewhere", 1)])
    assert (
        "ignored because the model does not have it: /elsewhere"
        in run("conform", model, "--bag", recording).stderr
    )


def test_wrong_use_with_recordings(run: Run, model: Path, traces: Path, tmp_path: Path) -> None:
    recording, other = bag(tmp_path / "bag", 1), write_bag(tmp_path / "other", [("/elsewhere", 1)])
    for arguments, message in (
        ([], "give a TRACE, or a recording by --bag"),
        ([traces, "--bag", recording], "--bag replaces the traces"),
        (["--bag", other], "no topic of the model was recorded"),
        (["--bag", tmp_path / "missing"], "this recording does not exist"),
        (["--bag", tmp_path], "holds no recording"),
    ):
        result = run("conform", model, *arguments)
        assert is_one_line_of_wrong_use(result, message)


def test_a_run_that_conforms(run: Run, model: Path, traces: Path) -> None:
    for given in ([traces], sorted(traces.iterdir()), [traces, *traces.iterdir()]):
        result = run("conform", model, *given)
        assert result.exit_code == 0
        (line,) = lines(result)
        assert line.startswith(f"{model}: conforms; 45 steps of 2 nodes replayed, 15 more")
    assert lines(run("conform", "-q", model, traces)) == []


def test_the_first_step_that_is_not_allowed(run: Run, model: Path, bad: Path) -> None:
    result = run("conform", model, bad)
    assert result.exit_code == 1
    found, summary = lines(result)
    file, line, text = found.split(":", 2)
    assert text == " Listen fires: Heard holds no token, 1 needed"
    record = json.loads(Path(file).read_text("utf-8").splitlines()[int(line) - 1])
    assert (record["event"], record["transition"]) == ("fire", "Listen")
    assert summary.startswith(f"{model}: violated; ")


def test_json(run: Run, model: Path, bad: Path, traces: Path) -> None:
    report = json.loads(run("conform", model, bad, "--json").stdout)
    assert list(report)[:6] == ["model", "status", "steps", "silent", "violations", "unknown"]
    (violation,) = report["violations"]
    assert violation["file"] == str(current_path(bad, "listener"))
    assert violation["node"] == "listener"
    assert violation["step"] == "Listen fires"
    assert violation["reason"] == "Heard holds no token, 1 needed"
    assert violation["line"] == violation["sequence"] + 1
    assert json.loads(run("conform", model, traces, "--json").stdout)["status"] == "conforms"


def test_what_cannot_be_known(run: Run, model: Path, traces: Path) -> None:
    result = run("conform", model, current_path(traces, "listener"))
    assert result.exit_code == 3
    assert ": unknown: Heard takes talker/Said/1 (Chatter): " in result.stdout
    assert "there is no trace of node talker" in result.stdout


def test_the_merged_run_is_a_trace(run: Run, model: Path, traces: Path, tmp_path: Path) -> None:
    output = tmp_path / "merged.jsonl"
    assert run("conform", model, traces, "-o", output).exit_code == 0
    header, *steps = read_records(output)
    assert isinstance(header, Header)
    assert (header.kind, header.verdict, header.signals) == ("witness", "conforms", "fully-enabled")
    events = [step.event for step in steps]
    assert events.count("take") == events.count("publish") == 3
    assert events.count("transfer") == 3 * 5


def test_the_merged_run_says_where_it_may_have_gone_wrong(
    run: Run, model: Path, traces: Path, bad: Path, tmp_path: Path
) -> None:
    output = tmp_path / "merged.jsonl"
    assert run("conform", model, traces, "--invariant", "Noted <= 1", "-o", output).exit_code == 1
    header, *steps = read_records(output)
    assert isinstance(header, Header)
    assert (header.property, header.verdict) == ("G (Noted <= 1)", "violated")
    fired = [step.sequence for step in steps if getattr(step, "transition", None) == "Listen"]
    assert header.cause == fired[1]
    assert header.decided["Noted > 1"][0] == fired[1]
    assert set(fired[:2]) <= set(header.causes)

    assert run("conform", model, bad, "-o", output).exit_code == 1
    header, *steps = read_records(output)
    assert isinstance(header, Header)
    assert header.property == "conformance of a run"
    last = max((step.sequence for step in steps if getattr(step, "transition", None) == "Listen"), default=0)
    assert (header.cause, header.decided) == (last, {"Heard < 1": [last, len(steps)]})


def test_settings(run: Run, model: Path, traces: Path, tmp_path: Path) -> None:
    result = run("conform", model, traces, "--set", "Words.tokens=4")
    assert result.exit_code == 1
    assert "the node starts: Words holds 3 tokens, in the model 4" in result.stdout
    # What the traces say counts where nothing else is said.
    told = records()
    for trace in told.values():
        trace[0] = replace(trace[0], settings=["Words.tokens=5"])  # type: ignore[call-arg]
    folder = write(tmp_path / "told", told)
    result = run("conform", "-v", model, folder)
    assert "the traces say: --set Words.tokens=5" in result.stderr
    assert "Words holds 3 tokens, in the model 5" in result.stdout
    assert run("conform", model, folder, "--set", "Words.tokens=3").exit_code == 0
    told["talker"][0] = replace(told["talker"][0], settings=[])  # type: ignore[call-arg]
    assert is_one_line_of_wrong_use(
        run("conform", model, write(folder, told)), "was recorded with settings that differ from those"
    )


class TestWrongUse:
    def test_traces(self, run: Run, model: Path, traces: Path, tmp_path: Path) -> None:
        empty = tmp_path / "empty"
        empty.mkdir()
        text = tmp_path / "text.jsonl"
        text.write_text("hello\n")
        cut = write(tmp_path / "gap", records())
        path = current_path(cut, "talker")
        path.write_text("".join(path.read_text("utf-8").splitlines(keepends=True)[1:]), "utf-8")
        double = tmp_path / "double.jsonl"
        double.write_bytes(current_path(traces, "talker").read_bytes())
        for given, says in (
            ([tmp_path / "none"], "none: cannot be read: No such file"),
            ([empty], "empty: holds no trace"),
            ([text], "text.jsonl:1: no JSON"),
            ([cut], "talker.jsonl:1: is not a trace of a node's run"),
            ([traces, double], "double.jsonl:1: begins at record 0 of node 'talker', as "),
        ):
            assert is_one_line_of_wrong_use(run("conform", model, *given), says)
        (empty / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
        words = "empty: holds no trace (this is a recording of rosbag2: give it with --bag)"
        assert is_one_line_of_wrong_use(run("conform", model, empty), words)
        result = run("conform", model)
        assert result.exit_code == 2

    def test_a_witness(self, run: Run, model: Path, tmp_path: Path) -> None:
        witness = tmp_path / "witness.jsonl"
        assert run("find", model, "--enabled", "Listen", "-o", witness).exit_code == 0
        assert is_one_line_of_wrong_use(
            run("conform", model, witness), "is a witness, not a trace of a node's run"
        )

    @uses("ends")
    def test_another_model(self, run: Run, model: Path, net: Path, traces: Path, tmp_path: Path) -> None:
        assert is_one_line_of_wrong_use(run("conform", net, traces), "this command needs a system model")
        other = records()
        other["talker"][0] = replace(other["talker"][0], model="other")  # type: ignore[call-arg]
        folder = write(tmp_path / "other", other)
        from dineros.metamodel.files import save

        save(talker(), tmp_path / "talker.sym.xmi")
        assert is_one_line_of_wrong_use(
            run("conform", tmp_path / "talker.sym.xmi", folder),
            "is a trace of model 'other', not of 'greeting'",
        )


def test_invariants_are_checked_in_every_marking(run: Run, model: Path, traces: Path) -> None:
    kept = run("conform", model, traces, "--invariant", "Words + Said <= 3", "--invariant", "Noted <= 3")
    assert kept.exit_code == 0
    assert lines(kept)[:2] == ["Words + Said <= 3: holds throughout", "Noted <= 3: holds throughout"]
    broken = run("conform", model, traces, "--invariant", "signal(Button) -> Words >= 3", "--json")
    assert broken.exit_code == 1
    assert json.loads(broken.stdout)["invariants"] == {"signal(Button) -> Words >= 3": False}
    assert "does not hold after" in run("conform", model, traces, "--invariant", "Noted <= 0").stdout


def test_an_invariant_that_is_none(run: Run, model: Path, traces: Path) -> None:
    result = run("conform", model, traces, "--invariant", "Nothing >= 1")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
