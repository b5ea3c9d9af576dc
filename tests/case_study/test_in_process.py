"""The case study in one process, with its handlers and its simulated cell."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.metamodel.records import Fire, node_traces, read_trace
from dineros.runtime.application.observer import Observer
from tests.case_study.conftest import WORKSPACE

MODEL = WORKSPACE.parent / "sorting.sym.xmi"
OBJECTS = ["--set", "RedObjects.tokens=2", "--set", "GreenObjects.tokens=2"]


def dineros(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.long
@pytest.mark.parametrize("way", ["--local", "--simulate"])
def test_all_objects_are_sorted_and_no_arm_starts_while_it_is_unsafe(way: str, tmp_path: Path) -> None:
    traces = tmp_path / "traces"
    options: list[str | Path] = [
        way,
        "--seed",
        "1",
        "--until",
        "Shown >= 5",
        "--timeout",
        "120",
        "--trace",
        traces,
    ]
    done = dineros("run", MODEL, *options, *OBJECTS)
    assert done.exit_code == 0, done.output
    # The traces say how the model was changed.
    replayed = dineros("conform", MODEL, traces, "--invariant", "PickRun + PlaceRun <= 1")
    assert replayed.exit_code == 0, replayed.output

    observer, started = Observer(), 0
    for record in read_trace(node_traces(traces)["executor"]):
        if isinstance(record, Fire) and record.transition.endswith((".TPick", ".TPlace")):
            started += 1
            assert observer.marking.get("Unsafe", 0) == 0
        observer.see([record])
    assert started == 10

    shown = [
        token.data
        for record in read_trace(node_traces(traces)["feedback"])
        if isinstance(record, Fire)
        for tokens in record.made.values()
        for token in tokens
    ]
    assert sorted(str(data["color"]) for data in shown) == ["blue", "green", "green", "red", "red"]
    assert len({str(data["name"]) for data in shown}) == 5
    assert all(data["placeSuccess"] for data in shown)
