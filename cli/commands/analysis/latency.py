"""``dineros latency``: how long callbacks and chains of them take, with the times of a model."""

from __future__ import annotations

from functools import partial
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
    "dineros latency robot.sym.xmi --bounds",
)
@model_argument()
@click.option("--from", "first", metavar="X", help="Callback or topic at which data begins.")
@click.option("--to", "last", metavar="Y", help="Callback or topic at which it ends.")
@click.option("--bounds", is_flag=True, help="Give safe bounds instead of exact times: quick at any size.")
@settings_option
@json_option
def latency(
    model: Path, first: str | None, last: str | None, bounds: bool, settings: tuple[str, ...], as_json: bool
) -> int:
    """Compute the least and greatest time that data takes through a model of ROS 2.

    With --from and --to: from the release of callback X, or a publication on topic X, to the end of callback
    Y, or the publication on topic Y; and whether an instance can be lost. Also the reaction time (how long it
    takes until what happens just after a release shows in an output) and the data age (how long an output
    stays the newest one). Without them: the response time of each callback, the longest history of each
    reader, and which timers lose ticks.

    Times are exact. If the search does not end within --timeout or --memory, or with --bounds, the answers
    are safe bounds instead: nothing takes longer than "at most" says.

    The model says how long callbacks, messages and periods take. If one of these times is missing, the answer
    names it. The exit status is 3 if a bound is open.
    """
    if (first is None) != (last is None):
        raise click.UsageError("--from and --to go together")
    start_quickly()
    from dineros.analysis.bounds.answers import Bounds
    from dineros.analysis.bounds.combining import known_everything, known_latency
    from dineros.analysis.latencies.answers import Everything, Latencies, end_of, require_times
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.times.rates import TooManyOnTheWayError

    net = load_valid(model, settings)
    if not isinstance(net, sym.SystemModel):
        raise DinerosError("latencies are those of a system model", location=Location(model))
    run = search()
    saying = _Saying(model, f"{first} to {last}", as_json)
    run.draft(saying.nothing)
    run.stage("bounding times")
    reason = ""
    try:
        require_times(net)
        ends = None if first is None or last is None else (end_of(net, first), end_of(net, last))
        safe = Bounds(net)
        found = bound = safe.everything() if ends is None else safe.between(*ends)
        if not bounds:
            run.draft(partial(saying.all, bound))
            run.stage("measuring times")
            try:
                asked = Latencies(net, run.budget())
                reason = asked.reason and run.reason(asked.reason)
                if isinstance(bound, Everything):
                    found = known_everything(asked.everything(), bound)
                elif ends is not None:
                    found = known_latency(asked.between(*ends), bound)
            except TooManyOnTheWayError as error:
                reason = error.message
    except DinerosError as error:
        error.location = error.location or Location(model)
        raise
    with run.answer():
        return saying.all(found, reason)


class _Saying:
    """Prints what was found.

    Parameters
    ----------
    model : Path
        The file.
    chain : str
        What is asked, if it is a chain.
    as_json : bool
        Whether JSON is printed.
    """

    def __init__(self, model: Path, chain: str, as_json: bool) -> None:
        self.model, self.chain, self.as_json = model, chain, as_json

    def nothing(self, ending: str) -> int:
        """Say that the search ended before anything was found."""
        if self.as_json:
            say_json({"model": str(self.model), "reason": ending})
        else:
            say(f"open: {ending}")
        return UNKNOWN

    def all(self, found: Everything | Latency, ended: str) -> int:
        """Say what is known, and why the search for exact times ended early; return the exit status."""
        from dineros.analysis.bounds.answers import ASSUMES
        from dineros.analysis.latencies.answers import Latency

        times = [found] if isinstance(found, Latency) else list(found.callbacks.values())
        is_exact = all(each.is_exact or each.greatest is None for each in times)
        if not isinstance(found, Latency):
            is_exact = is_exact and found.is_exact
        if self.as_json:
            assumed = {} if is_exact else {"assumes": ASSUMES}
            why = {"ended": ended} if ended else {}
            say_json({"model": str(self.model), **found.to_dict(), **assumed, **why})
        else:
            for line in self._of_chain(found) if isinstance(found, Latency) else _of_all(found):
                say(line)
            if ended:
                say(f"note: the search for exact times has not ended: {ended}")
            if not is_exact:
                say(f"note: these bounds are safe, and need not be reached; they assume that {ASSUMES}")
        return UNKNOWN if any(each.reason for each in times) else HOLDS

    def _of_chain(self, found: Latency) -> list[str]:
        lost = {True: ", an instance can be lost", False: "", None: ""}
        if found.greatest is not None:
            lost[None] = ", whether an instance can be lost is not known"
        lines = [f"{self.chain}: {_span(found)}{lost[found.is_lost]}"]
        longest = [("reaction time", found.reaction), ("data age", found.age)]
        words = [f"{name} up to {float(each.value):g} s" for name, each in longest if each is not None]
        if words:
            lines.append(", ".join(words))
        if found.reason:
            lines.append(f"no bound for {self.chain}: {found.reason}")
        return lines


def _of_all(found: Everything) -> list[str]:
    lines = []
    for name, each in found.callbacks.items():
        lines.append(f"callback {name}: {_span(each)}")
        if each.reason:
            lines.append(f"    no bound: {each.reason}")
    overflows = {True: ", can overflow", False: "", None: ", whether it can overflow is not known"}
    for name, (longest, can_overflow) in found.readers.items():
        lines.append(f"reader {name}: at most {longest} waiting{overflows[can_overflow]}")
    ticks = {True: "can lose ticks", False: "loses no tick", None: "whether it loses ticks is not known"}
    for name, loses in found.timers.items():
        lines.append(f"timer {name}: {ticks[loses]}")
    return lines


def _span(found: Latency) -> str:
    """Return bounds in words; a bound that is only approached has a sign."""
    if found.least is None:
        return "never ends" if not found.reason else "open"
    least = f"{'more than ' if not found.least.is_reached else ''}{float(found.least.value):g}"
    if found.greatest is None:
        return f"at least {least} s"
    greatest = f"{'less than ' if not found.greatest.is_reached else ''}{float(found.greatest.value):g}"
    if not found.is_exact:
        return f"at least {least} s, at most {greatest} s"
    return f"{least} s" if least == greatest else f"{least} to {greatest} s"
