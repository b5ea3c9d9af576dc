"""``dineros conform --bag``: whether some run of the model shows the messages of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS, UNKNOWN, VIOLATED, write_witness
from dineros.cli.console import note, say, say_json, summarise, warn
from dineros.cli.models import load_valid_system, say_rules
from dineros.cli.observing import opened
from dineros.cli.searching import search
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.observation.explaining import RecordingVerdict

_STATUS = {"conforms": HOLDS, "violated": VIOLATED, "unknown": UNKNOWN}


def explain_bag(
    model: Path,
    bag: Path,
    tolerance: float,
    midway: bool,
    output: Path | None,
    settings: Sequence[str],
    as_json: bool,
) -> int:
    """Explain a recording, say what is found, and return the exit status."""
    from dineros.observation.explaining import RecordingVerdict, explain
    from dineros.observation.recordings import Observed

    system = load_valid_system(model, settings)
    run = search()

    def so_far(ending: str) -> int:
        return _report(RecordingVerdict("unknown", reason=ending), model, as_json)

    run.draft(so_far)
    with opened(bag) as recording:
        say_rules(system, model)
        run.stage(f"explaining {counted(recording.count, 'message')}")
        observed = Observed(recording)
        verdict = explain(
            system,
            observed.recorded,
            observed.messages(),
            tolerance=tolerance,
            midway=midway,
            budget=run.budget(),
        )
    if output is not None:
        run.stage(f"writing {output.name}")
        if verdict.run is None:
            note(f"{output} is not written: there is no message without an explanation")
        else:
            write_witness(
                verdict.run,
                output,
                model,
                settings,
                "conformance of a recording",
                verdict.status,
                verdict.cause,
            )
    with run.answer():
        return _report(verdict, model, as_json)


def _report(verdict: RecordingVerdict, model: Path, as_json: bool) -> int:
    if as_json:
        say_json(verdict.to_dict(str(model)))
        return _STATUS[verdict.status]
    if verdict.others:
        warn(f"{model}: what the model does not have is left out: {', '.join(verdict.others)}")
    if verdict.hidden:
        warn(f"{model}: topics that were not recorded may have any messages: {', '.join(verdict.hidden)}")
    if verdict.status == "violated":
        say(f"{model}: {verdict.unexplained}", "bold red")
    elif verdict.status == "unknown":
        say(f"{model}: unknown: {verdict.reason}", "magenta")
    summarise(f"{model}: {verdict.status}; {counted(verdict.messages, 'message')} explained")
    return _STATUS[verdict.status]
