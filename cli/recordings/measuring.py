"""``dineros narrow --run``: proposes times for a model from the traces of its run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS
from dineros.cli.console import say_json, summarise
from dineros.cli.models import refuse_invalid
from dineros.cli.recordings.narrowing import chosen, print_proposals
from dineros.cli.searching import search
from dineros.metamodel.errors import DinerosError, Location, counted

if TYPE_CHECKING:
    from dineros.metamodel import sym
    from dineros.observation.measuring.proposing import TimeProposal


def narrow_by_run(
    model: Path,
    system: sym.SystemModel,
    traces: Path,
    threshold: float | None,
    accept: Sequence[int],
    output: Path | None,
    as_json: bool,
) -> int:
    """Propose times for a model from the traces of its run; write the model with the accepted ones.

    Raises
    ------
    DinerosError
        The traces cannot be read, or are those of a simulation.
    """
    from dineros.metamodel.files import save
    from dineros.metamodel.records import read_trace, traces_of_runs
    from dineros.observation.measuring.journals import JournalTimes
    from dineros.observation.measuring.proposing import give_times, time_proposals

    run = search()
    run.stage(f"reading {traces.name}")
    parts = traces_of_runs([traces])
    times = JournalTimes(system, {node: partial(read_trace, files) for node, files in parts.items()})
    found = time_proposals(system, times.seen(), traces.name)
    if times.is_simulated:
        raise DinerosError(
            "was simulated, so its times are not measurements",
            location=Location(traces),
            hint="record a run with --local, or on ROS 2",
        )
    accepted: list[TimeProposal] = []
    if output is not None:
        accepted = chosen(found, threshold, accept)
        give_times(system, accepted)
        refuse_invalid(system, output)
        save(system, output)
    with run.answer():
        if as_json:
            say_json(_report(model, found, accepted, output))
        elif output is not None:
            summarise(f"{output}: {counted(len(accepted), 'time')} accepted of {traces.name}")
        else:
            print_proposals(found, traces)
    return HOLDS


def _report(
    model: Path, found: Sequence[TimeProposal], accepted: Sequence[TimeProposal], output: Path | None
) -> dict[str, object]:
    narrowed = None
    if output is not None:
        narrowed = {"model": str(output), "accepted": [each.to_dict() for each in accepted]}
    return {"model": str(model), "times": [each.to_dict() for each in found], "narrowed": narrowed}
