"""``dineros conform --bag``: checks whether some run of the model shows the messages of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import STATUSES, VIOLATED, write_witness
from dineros.cli.console import note, say, say_json, summarise, warn
from dineros.cli.models import load_valid_system, say_rules
from dineros.cli.observing import opened
from dineros.cli.searching import search
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.observation.explaining import RecordingVerdict
    from dineros.observation.recordings import Untaken


def explain_bag(
    model: Path,
    bag: Path,
    tolerance: float,
    midway: bool,
    output: Path | None,
    settings: Sequence[str],
    as_json: bool,
) -> int:
    """Explain a recording, print the result, and return the exit status."""
    from dineros.observation.explaining import RecordingVerdict, explain
    from dineros.observation.recordings import Observed

    system = load_valid_system(model, settings)
    run = search()

    def so_far(ending: str) -> int:
        return _report(RecordingVerdict("unknown", reason=ending), (), model, midway, as_json)

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
            note(f"{output} is not written: all messages are explained")
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
        return _report(verdict, observed.untaken, model, midway, as_json)


def _report(
    verdict: RecordingVerdict, untaken: Sequence[Untaken], model: Path, midway: bool, as_json: bool
) -> int:
    """Print the result; return the exit status, which is also 1 if a response was not taken."""
    status = VIOLATED if untaken and verdict.status == "conforms" else STATUSES[verdict.status]
    if as_json:
        say_json({**verdict.to_dict(str(model)), "untaken": [each._asdict() for each in untaken]})
        return status
    if verdict.others:
        warn(f"{model}: ignored because the model does not have it: {', '.join(verdict.others)}")
    if verdict.hidden:
        warn(f"{model}: topics that were not recorded may carry any messages: {', '.join(verdict.hidden)}")
    if midway and verdict.status == "conforms":
        warn(f"{model}: {_cannot_tell(verdict.untold)}")
    if verdict.unexplained is not None and verdict.status == "violated":
        say(f"{model}: {verdict.unexplained}", "bold red")
    for silence in verdict.silences:
        say(f"{model}: {silence}", "bold red")
    for each in untaken:
        say(f"{model}: {each}", "bold red")
    if verdict.status == "unknown":
        say(f"{model}: unknown: {verdict.reason}", "magenta")
    summarise(f"{model}: {verdict.status}; {counted(verdict.messages, 'message')} explained")
    return status


def _cannot_tell(untold: Sequence[str]) -> str:
    """Return what `--midway` leaves open, by the topics on which the initial states of parts depend."""
    if not untold:
        return "--midway lets the run start in any reachable state; how it is reached is not checked"
    return (
        "--midway cannot check that the initial states of the nodes agree on the messages that were sent "
        f"before on {', '.join(untold)}; so it may accept recordings that the model does not allow"
    )
