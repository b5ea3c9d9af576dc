"""``dineros latency``: how long callbacks and chains of them take, with the times of a model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import HOLDS, UNKNOWN, load_valid
from dineros.cli.console import say, say_json
from dineros.cli.options import json_option, model_argument, settings_option
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.latencies.answers import Everything, Latency


@search_command(
    "dineros latency chain.sym.xmi",
    "dineros latency chain.sym.xmi --from sense --to act",
)
@model_argument()
@click.option("--from", "first", metavar="X", help="Callback or topic at which data begins.")
@click.option("--to", "last", metavar="Y", help="Callback or topic at which it ends.")
@settings_option
@json_option
def latency(
    model: Path, first: str | None, last: str | None, settings: tuple[str, ...], as_json: bool
) -> int:
    """Compute the least and greatest time that data takes through a model of ROS 2, exactly.

    With --from and --to: from the release of callback X, or a publication on topic X, to the end of callback
    Y, or the publication on topic Y; and whether an instance can be lost. Also the reaction time (how long it
    takes until what happens just after a release shows in an output) and the data age (how long an output
    stays the newest one). Without them: the response time of each callback, the longest history of each
    reader, and which timers lose ticks.

    The model says how long callbacks, messages and periods take. If one of these times is missing, the answer
    names it. The exit status is 3 if a bound is open.
    """
    if (first is None) != (last is None):
        raise click.UsageError("--from and --to go together")
    start_quickly()
    from dineros.analysis.latencies.answers import Latencies, end_of
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location

    net = load_valid(model, settings)
    if not isinstance(net, sym.SystemModel):
        raise DinerosError("latencies are those of a system model", location=Location(model))
    run = search()

    def so_far(ending: str) -> int:
        if as_json:
            say_json({"model": str(model), "reason": ending})
        else:
            say(f"open: {ending}")
        return UNKNOWN

    run.draft(so_far)
    run.stage("measuring times")
    try:
        ends = None if first is None or last is None else (end_of(net, first), end_of(net, last))
        asked = Latencies(net, run.budget())
        if ends is not None:
            found = asked.between(*ends)
            with run.answer():
                return _say_latency(f"{first} to {last}", found, model, as_json)
        everything = asked.everything()
    except DinerosError as error:
        error.location = error.location or Location(model)
        raise
    with run.answer():
        return _say_everything(everything, asked.reason, model, as_json)


def _say_latency(what: str, found: Latency, model: Path, as_json: bool) -> int:
    if as_json:
        say_json({"model": str(model), **found.to_dict()})
    else:
        say(f"{what}: {_span(found)}{', an instance can be lost' if found.is_lost else ''}")
        longest = [("reaction time", found.reaction), ("data age", found.age)]
        words = [f"{name} up to {float(each.value):g} s" for name, each in longest if each is not None]
        if words:
            say(", ".join(words))
        if found.reason:
            say(f"no bound for {what}: {found.reason}")
    return UNKNOWN if found.reason else HOLDS


def _say_everything(found: Everything, reason: str, model: Path, as_json: bool) -> int:
    if as_json:
        say_json({"model": str(model), **found.to_dict(), **({"reason": reason} if reason else {})})
    else:
        for name, each in found.callbacks.items():
            say(f"callback {name}: {_span(each)}")
            if each.reason:
                say(f"    no bound: {each.reason}")
        for name, (longest, overflows) in found.readers.items():
            say(f"reader {name}: at most {longest} waiting{', can overflow' if overflows else ''}")
        for name, loses in found.timers.items():
            say(f"timer {name}: {'can lose ticks' if loses else 'loses no tick'}")
        if reason:
            say(f"open: {reason}")
    return UNKNOWN if reason or any(each.reason for each in found.callbacks.values()) else HOLDS


def _span(found: Latency) -> str:
    """Return bounds in words; a bound that is only approached has a sign."""
    if found.least is None:
        return "never ends" if not found.reason else "open"
    least = f"{'more than ' if not found.least.is_reached else ''}{float(found.least.value):g}"
    if found.greatest is None:
        return f"at least {least} s"
    greatest = f"{'less than ' if not found.greatest.is_reached else ''}{float(found.greatest.value):g}"
    words = f"{least} s" if least == greatest else f"{least} to {greatest} s"
    return words if found.is_exact else f"within {words} (safe bounds)"
