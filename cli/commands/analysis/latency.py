"""``dineros latency``: times of callbacks and chains of callbacks, from the times of a model."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import HOLDS, UNKNOWN, load_valid, write_witness
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.options import (
    flag,
    json_option,
    model_argument,
    output_option,
    settings_option,
    value_option,
)
from dineros.cli.presentation.answers import say_assumes
from dineros.cli.presentation.reports.latencies import (
    left_out,
    lines_of_all,
    lines_of_depths,
    span,
    write_latency_page,
)
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dineros.analysis.latencies.answers import End, Latencies
    from dineros.analysis.latencies.depths import Depth
    from dineros.analysis.latencies.results import Everything, Latency
    from dineros.analysis.witnesses.witness import Witness
    from dineros.metamodel import sym

EXACT_SECONDS = 60.0
"""Seconds for exact times if the command has no limit; then bounds are the answer."""


@search_command(
    "dineros latency chain.sym.xmi",
    "dineros latency chain.sym.xmi --from sense --to act",
    "dineros latency chain.sym.xmi --bounds -o report.html",
    "dineros latency chain.sym.xmi --depths",
)
@model_argument()
@value_option("--from X", "Callback or topic at which data begins.", into="first")
@value_option("--to Y", "Callback or topic at which it ends.", into="last")
@flag("--bounds", "Give safe bounds instead of exact times; fast for models of any size.")
@flag("--depths", "Find the smallest depth at which each subscription loses no message.")
@output_option("Write a page (.html); or, with --from and --to, the run that takes longest (.jsonl).")
@settings_option
@json_option
def latency(
    model: Path,
    first: str | None,
    last: str | None,
    bounds: bool,
    depths: bool,
    output: Path | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Compute the least and greatest time that data takes through a model of ROS 2.

    With --from and --to: from the release of callback X, or a publication on topic X, to the end of callback
    Y, or the publication on topic Y; and whether an instance can be lost. Also the reaction time (how long it
    takes until what happens just after a release shows in an output) and the data age (how long an output
    stays the newest one). Without them: the response time of each callback, the longest history of each
    reader, and which timers lose ticks.

    Times are exact. If the search does not end within --timeout (60 s if it is not given) or --memory, or
    with --bounds, the answers are safe bounds instead: nothing takes longer than "at most" says.

    With --depths: the least depth of each reader history with which no message is displaced.

    The model says how long callbacks, messages and periods take. If one of these times is missing, the answer
    names it. The exit status is 3 if a bound is open.
    """
    if (first is None) != (last is None):
        raise click.UsageError("--from and --to must be given together")
    is_page = output is not None and output.suffix.lower() == ".html"
    if output is not None and not is_page and (first is None or bounds):
        raise click.UsageError("-o writes a run with --from and --to and without --bounds, or a page (.html)")
    if depths and (first is not None or bounds or output is not None):
        raise click.UsageError("--depths cannot be combined with --from, --to, --bounds or -o")
    start_quickly(model)
    from dineros.analysis.bounds.answers import Bounds
    from dineros.analysis.bounds.combining import known_everything, known_latency
    from dineros.analysis.latencies.answers import Latencies, end_of, require_times
    from dineros.analysis.latencies.results import Everything, Latency
    from dineros.analysis.model.assumptions import of_source
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.guards.using import guarded
    from dineros.metamodel.times.rates import TooManyOnTheWayError

    net = load_valid(model, settings)
    if not isinstance(net, sym.SystemModel):
        raise DinerosError("latencies are defined for system models only", location=Location(model))
    run = search()
    saying = _Saying(model, net, f"{first} to {last}", as_json, of_source(net))
    run.draft(saying.nothing)
    run.stage("bounding times")
    reason, asked = "", None
    try:
        require_times(net, with_guards=not depths and output is None)
        if depths:
            from dineros.analysis.latencies.depths import least_depths

            needed = least_depths(net, run.budget())
            with run.answer():
                return saying.depths(needed)
        ends = None if first is None or last is None else (end_of(net, first), end_of(net, last))
        safe = Bounds(net)
        found = bound = safe.everything() if ends is None else safe.between(*ends)
        if guarded(net):
            reason = "models with guards are not searched for them yet"
        elif not bounds:
            run.draft(partial(saying.all, bound))
            run.stage("measuring times")
            try:
                asked = Latencies(net, run.budget().unless_limited(EXACT_SECONDS))
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
        status = saying.all(found, reason)
    if output is None:
        return status

    def not_written(ending: str) -> int:
        warn(f"{output} is not written: {ending}")
        return status

    run.draft(not_written)
    run.stage(f"writing {output.name}")
    worst = _worst(asked, found, ends, saying.chain)
    if is_page:
        everything = found if isinstance(found, Everything) else None
        if everything is None:
            everything = safe.everything()
            if asked is not None and not reason:
                everything = known_everything(asked.everything(), everything)
        chains = saying.of_chain(found) if isinstance(found, Latency) else []
        write_latency_page(
            everything, safe, net, output, model, settings, chains, worst, _notes(net, found, reason)
        )
    elif worst is None:
        warn(f"{output} is not written: no run was found")
        return status
    else:
        write_witness(worst[1], output, model, settings, saying.chain, "holds")
    if not as_json:
        summarise(f"{model} -> {output}")
    return status


def _worst(
    asked: Latencies | None, found: Everything | Latency, ends: tuple[End, End] | None, chain: str
) -> tuple[str, Witness] | None:
    """Return the longest time in words, and its run; None if it is unknown."""
    from dineros.analysis.latencies.paths import callback_pages
    from dineros.analysis.latencies.results import Latency
    from dineros.analysis.witnesses.witness import witness_of

    if asked is None:
        return None
    if isinstance(found, Latency):
        assert ends is not None
        first, last, time = *ends, found
    else:
        known = {name: each for name, each in found.callbacks.items() if each.is_exact and each.greatest}
        if not known:
            return None
        name, time = max(known.items(), key=lambda item: item[1].greatest.value if item[1].greatest else 0)
        first = next(page for page in callback_pages(asked.model) if page.id == name)
        last, chain = None, f"callback {name}"
    if time.greatest is None or not time.is_exact:
        return None
    shown = asked.longest_instance(first, last, time)
    if shown is None:
        return None
    words = f"{chain} takes {float(time.greatest.value):g} s, counted from {shown.began:g} s"
    return words, witness_of(asked.subject, shown.trace, times=shown.times)


def _notes(model: sym.SystemModel, found: Everything | Latency, reason: str) -> list[str]:
    from dineros.analysis.bounds.answers import ASSUMES
    from dineros.analysis.latencies.results import Latency
    from dineros.analysis.model.assumptions import of_source

    notes = [f"exact times are not known: {reason}"] if reason else []
    if not found.is_exact:
        notes.append(f"some bounds are safe bounds that may never be reached; they assume that {ASSUMES}")
    if not isinstance(found, Latency):
        notes += left_out(model, found)
    return [*notes, *(f"assumes: {each}" for each in of_source(model))]


_WORDS = {"reaction": "reaction time", "age": "data age"}


class _Saying:
    """Prints the results.

    `of_source`: the assumption about the source of the model, if there is one.
    """

    def __init__(
        self, model: Path, net: sym.SystemModel, chain: str, as_json: bool, of_source: list[str]
    ) -> None:
        self.model, self.net, self.chain, self.as_json, self.of_source = model, net, chain, as_json, of_source

    def nothing(self, ending: str) -> int:
        """Print that the search ended without a result."""
        if self.as_json:
            say_json({"model": str(self.model), "reason": ending})
        else:
            say(f"open: {ending}")
        return UNKNOWN

    def all(self, found: Everything | Latency, ended: str) -> int:
        """Print the known results, and why the search for exact times ended early; return the exit status."""
        from dineros.analysis.bounds.answers import ASSUMES
        from dineros.analysis.latencies.results import Latency

        times = [found] if isinstance(found, Latency) else list(found.callbacks.values())
        is_exact = all(each.is_exact or each.greatest is None for each in times)
        if not isinstance(found, Latency):
            is_exact = is_exact and found.is_exact
        if self.as_json:
            assumed = {} if is_exact else {"assumes": ASSUMES}
            if self.of_source:
                assumed = {"assumes": "; ".join([*assumed.values(), *self.of_source])}
            why = {"ended": ended} if ended else {}
            say_json({"model": str(self.model), **found.to_dict(), **assumed, **why})
        else:
            for line in self.of_chain(found) if isinstance(found, Latency) else lines_of_all(found):
                say(line)
            if ended:
                say(f"note: exact times are not known: {ended}")
            if not is_exact:
                say(f"note: these are safe bounds that may never be reached; they assume that {ASSUMES}")
            for line in [] if isinstance(found, Latency) else left_out(self.net, found):
                say(f"note: {line}")
            say_assumes(self.of_source)
        return UNKNOWN if any(time.reason for time in times) else HOLDS

    def depths(self, found: Mapping[str, Depth]) -> int:
        """Print the needed depths; return the exit status."""
        if self.as_json:
            depths = {name: each.to_dict() for name, each in found.items()}
            assumed = {"assumes": "; ".join(self.of_source)} if self.of_source else {}
            say_json({"model": str(self.model), "depths": depths, **assumed})
        else:
            for line in lines_of_depths(found):
                say(line)
            say_assumes(self.of_source)
        return UNKNOWN if any(each.least is None for each in found.values()) else HOLDS

    def of_chain(self, found: Latency) -> list[str]:
        """Return the results for the chain, a line each."""
        lost = {True: ", an instance can be lost", False: "", None: ""}
        if found.greatest is not None:
            lost[None] = "; it is unknown whether an instance can be lost"
        lines = [f"{self.chain}: {span(found)}{lost[found.is_lost]}"]
        longest = [("reaction time", found.reaction), ("data age", found.age)]
        words = [f"{name} up to {float(each.value):g} s" for name, each in longest if each is not None]
        if words:
            lines.append(", ".join(words))
        if found.reason:
            lines.append(f"no bound for {self.chain}: {found.reason}")
        for reason in dict.fromkeys(found.reasons.values()):
            names = [words for name, words in _WORDS.items() if found.reasons.get(name) == reason]
            lines.append(f"{' and '.join(names)} not known: {reason}")
        return lines
