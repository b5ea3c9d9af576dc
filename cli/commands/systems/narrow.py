"""``dineros narrow``: finds which callbacks lead to which messages in a recording."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import click

from dineros.cli.analysing import HOLDS, STATUSES, VIOLATED
from dineros.cli.models import load_valid_system, refuse_invalid
from dineros.cli.observing import recording_options
from dineros.cli.options import json_option, model_argument, model_path_option, output_option, value_option
from dineros.cli.outputs import refuse_output
from dineros.cli.recordings.evidence import gathered
from dineros.cli.recordings.measuring import narrow_by_run
from dineros.cli.recordings.narrowing import (
    chosen,
    print_calls,
    print_json,
    print_narrowed,
    print_proposals,
    print_traced,
    refuse_given,
    subject_of,
    write,
)
from dineros.cli.searching import search
from dineros.cli.supervising import search_command


@search_command(
    "dineros narrow seen.sym.xmi --bag recording",
    "dineros narrow seen.sym.xmi --bag recording --threshold 0.95 -o narrowed.sym.xmi",
    "dineros narrow seen.sym.xmi --bag recording --accept 1 -o narrowed.sym.xmi",
    "dineros narrow seen.sym.xmi --tracing trace --threshold 0.95 -o narrowed.sym.xmi",
    "dineros narrow watch.sym.xmi --run watched/ --threshold 0.95 -o measured.sym.xmi",
)
@model_argument()
@model_path_option("--bag RECORDING", "A recording of rosbag2: its folder, or one .mcap or .db3 file.")
@model_path_option(
    "--tracing TRACE",
    "Tracing files of ros2_tracing: a folder of LTTng, read by babeltrace2, or its text output.",
)
@model_path_option(
    "--run TRACES",
    "The traces of a run of this model: the folder of `run --trace`. They propose times.",
    into="traces",
)
@value_option(
    "--within S",
    "Maximum delay (seconds) between a message and its effect.",
    type=click.FloatRange(min=0, min_open=True, max=3600),
    default=1.0,
    show_default=True,
)
@value_option(
    "--threshold P", "Accept all proposals of at least this confidence.", type=click.FloatRange(min=0, max=1)
)
@value_option("--accept N", "Accept the proposal of this number; repeatable.", type=int, multiple=True)
@output_option("Write the narrowed model: .xmi or .pnml.")
@recording_options()
@json_option
def narrow(
    model: Path,
    bag: Path | None,
    tracing: Path | None,
    traces: Path | None,
    within: float,
    threshold: float | None,
    accept: tuple[int, ...],
    output: Path | None,
    tolerance: float,
    midway: bool,
    as_json: bool,
) -> int:
    """Propose which callbacks of an imported model lead to which messages, and narrow it by what is accepted.

    A proposal says that a message on a topic always, sometimes or never follows another one, or that a timer
    publishes it; with frequency, delays, and the probability that it holds next time. If services record
    their calls (service introspection), calls are proposed as well, and what follows requests and answers.
    Tracing files show which callback was running when a message was published, and take precedence over
    times; they can also replace the recording.

    In the narrowed model, accepted proposals hold, and the rest stays open. The model explains the recording:
    proposals that contradict it are weakened, or withdrawn, and listed. A file next to the model contains the
    resulting facts, for the next import.

    Times are proposed as well, with sample size, quantiles and the greatest observed time: by traces of a run
    (--run) durations, periods and jitter of timers, and latencies. Accepted ones are intervals of the model,
    each with its source.

    A response that a server sent and no client took is a finding, for example if the client waits in a
    callback whose group the response needs.

    Exit status 0: success; 1: there is such a response, or the model does not explain the recording although
    it is open; 3: unknown.
    """
    is_accepting = threshold is not None or bool(accept)
    if is_accepting != (output is not None):
        raise click.UsageError("--threshold and --accept require -o, and -o requires one of them")
    if output is not None:
        refuse_output(output, (".xmi", ".pnml"))
        if traces is None:
            refuse_given(output)
    if traces is not None and (bag is not None or tracing is not None):
        raise click.UsageError(
            "--run is for a model whose nodes recorded traces: give no --bag and no --tracing"
        )
    if bag is None and tracing is None and traces is None:
        raise click.UsageError(
            "name the observations: --bag RECORDING, --tracing TRACE, or both; or --run TRACES"
        )
    from dineros.observation.measuring.proposing import TimeProposal
    from dineros.observation.narrowing import Proposal, narrowed

    system = load_valid_system(model)
    if traces is not None:
        return narrow_by_run(model, system, traces, threshold, accept, output, as_json)
    subject = subject_of(model, system)
    run = search()
    with ExitStack() as open_files:
        evidence = gathered(subject.system, subject.given, bag, tracing, within, run.stage, open_files)
        proposed: list[Proposal | TimeProposal] = [*evidence.proposals, *evidence.times]
        made = None
        if output is not None:
            accepted = chosen(proposed, threshold, accept)
            times = [each for each in accepted if isinstance(each, TimeProposal)]
            run.stage(f"explaining {evidence.source.name}")
            made = narrowed(
                subject.system,
                evidence.recorded,
                evidence.messages,
                [each for each in accepted if isinstance(each, Proposal)],
                times=times,
                given=subject.given,
                id=subject.id,
                tolerance=tolerance,
                midway=midway,
                budget=run.budget(),
            )
            refuse_invalid(made.imported.model, output)
            write(made, output, evidence)
    with run.answer():
        if as_json:
            print_json(subject, evidence, made, output)
        elif made is None:
            print_proposals(proposed, evidence.source)
            print_calls(evidence.calls, evidence.untaken)
            print_traced(evidence)
        elif output is not None:
            print_narrowed(made, output, evidence)
    if evidence.untaken and (made is None or made.verdict.status == "conforms"):
        return VIOLATED
    return HOLDS if made is None else STATUSES[made.verdict.status]
