"""`check -o TRACE`: how each finding comes about, as a trace."""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel.records import Drop, Header, read_records
from tests.cli.conftest import Run
from tests.support.programs.commands import NETS, lines


def test_the_witnesses_of_a_check(run: Run, model: Path, tmp_path: Path) -> None:
    output = tmp_path / "trace.jsonl"
    change = ("--set", "Chatter.publisher.Said.limit=1", "--set", "Chatter.subscriber.Heard.limit=1")
    result = run("check", model, *change, "-o", output)
    assert result.exit_code == 1
    found = [line for line in lines(result) if line.startswith("error: ")]
    assert [line.partition(" can overflow")[0] for line in found] == [
        "error: publisher queue of Said (topic chatter)",
        "error: subscriber queue of Heard (topic chatter)",
    ]
    second, third = tmp_path / "trace.2.jsonl", tmp_path / "trace.3.jsonl"
    assert [line for line in lines(result) if " -> " in line] == [
        f"{model} -> {path}: {len(list(read_records(path))) - 1} steps" for path in (output, second, third)
    ]
    assert next(iter(read_records(third))).verdict == "deadlock"  # type: ignore[attr-defined]
    for path, queue in ((output, "publisher"), (second, "subscriber")):
        header, *_, last = read_records(path)
        assert isinstance(header, Header)
        assert (header.verdict, header.settings) == ("queue-overflow", [change[1], change[3]])
        assert header.property is not None
        assert header.property.startswith(f"{queue} queue of ")
        assert isinstance(last, Drop)
        assert last.queue == queue


def test_nothing_found_writes_nothing(run: Run, tmp_path: Path) -> None:
    net, output = tmp_path / "cycle.net", tmp_path / "trace.jsonl"
    net.write_text(NETS["cycle"])
    assert run("check", net, "-o", output).exit_code == 0
    assert not output.exists()


def test_capacities_have_no_trace(run: Run, model: Path, tmp_path: Path) -> None:
    result = run("check", model, "--suggest-capacities", "-o", tmp_path / "trace.jsonl")
    assert result.exit_code == 2
    assert "-o cannot be combined with --suggest-capacities" in result.stderr
