"""``dineros conform``: checks whether the model allows a run."""

from __future__ import annotations

from pathlib import Path

import click

from dineros.cli.observing import recording_options
from dineros.cli.options import (
    ModelPath,
    format_option,
    json_option,
    middleware_option,
    model_argument,
    model_path_option,
    output_option,
    settings_option,
    value_option,
    values_option,
)
from dineros.cli.recordings.explaining import explain_bag
from dineros.cli.recordings.replaying import replay
from dineros.cli.supervising import search_command


@search_command(
    "dineros conform sorting.sym.xmi run/",
    "dineros conform sorting.sym.xmi run/ --invariant 'PickRun + PlaceRun <= 1' --json",
    "dineros conform sorting.sym.xmi run/ --allowance 0.01 --format sarif",
    "dineros conform robot.sym.xmi --bag recording -o why.jsonl",
)
@model_argument()
@click.argument("traces", type=ModelPath(), metavar="TRACE...", nargs=-1)
@output_option(
    "Write the merged run, with the steps inside of channels, as a trace of the flattened net; with "
    "`--bag` a run of the model up to the last message that it can explain."
)
@value_option(
    "--orders N",
    "The number of orders to try if losses or messages without ids allow several.",
    type=click.IntRange(min=1),
    default=50,
    show_default=True,
)
@values_option(
    "--invariant EXPR",
    "A condition that must always hold, such as 'PickRun + PlaceRun <= 1'; repeatable.",
    into="invariants",
)
@value_option(
    "--allowance S",
    "Seconds by which a recorded time may exceed the declared one, because clocks differ and machines "
    "are busy.",
    type=click.FloatRange(min=0, max=3600),
    default=0.005,
    show_default=True,
)
@model_path_option(
    "--bag RECORDING",
    "Check a recording of rosbag2 instead of traces: find a run of the model with the same messages.",
)
@recording_options("With `--bag`: ")
@middleware_option
@settings_option
@format_option("what is found")
@json_option
def conform(
    model: Path,
    traces: tuple[Path, ...],
    output: Path | None,
    orders: int,
    invariants: tuple[str, ...],
    allowance: float,
    bag: Path | None,
    tolerance: float,
    midway: bool,
    settings: tuple[str, ...],
    format: str,
    as_json: bool,
) -> int:
    """Replay the traces of a run on the flattened model, or explain a recording.

    TRACE is a file that a node recorded, or a folder of them. Every step must be a firing that the model
    allows. Between nodes, messages order the steps, not clocks; steps inside of channels are inferred.
    Without `--set`, the model is changed as it was for the run.

    An invariant on places of one node is checked in every marking of it; one on several nodes in one of the
    orders that the messages allow.

    Times that the model declares are compared with those of the run: durations, periods of timers, latencies
    of messages. A time counts only where it breaks its bound in any case, however long something waited.

    A recording contains only messages: it conforms if some run of the model shows exactly these messages, in
    the order of each topic. The first message that no run shows is named, with the messages that were
    possible. Two further findings: a regular topic falls silent although the model must publish on it again,
    and a response was sent that no client took.

    Exit status 0: the run conforms; 1: a step is not allowed, a declared time or an invariant does not hold,
    or one of these findings; 3: unknown.
    """
    format = "json" if as_json else format
    if bag is not None:
        if traces or invariants:
            raise click.UsageError(
                "--bag replaces the traces: it cannot be combined with TRACE or --invariant"
            )
        if format not in ("text", "json"):
            raise click.UsageError(f"--format {format} is not available for a recording")
        return explain_bag(model, bag, tolerance, midway, output, settings, format == "json")
    if not traces:
        raise click.UsageError("give a TRACE, or a recording by --bag")
    return replay(model, traces, orders, invariants, allowance, output, settings, format)
