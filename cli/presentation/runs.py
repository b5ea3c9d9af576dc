"""Prints the result of a run, as text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.cli.console import say, say_json, summarise, warn
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.cli.running.running import Outcome

_ENDINGS: dict[str, str] = {
    "reached": "the condition holds",
    "ended": "all nodes have ended",
    "idle": "nothing is left to do",
    "timeout": "time is over",
    "interrupted": "interrupted",
    "failed": "a node could not continue",
    "deviated": "a step is not allowed by the model",
}


def say_run(outcome: Outcome, as_json: bool) -> None:
    """Print how a run ended, the marking, and counts."""
    observer, verdict, trace = outcome.observer, outcome.verdict, outcome.options.trace
    marking = {place: tokens for place, tokens in sorted(observer.marking.items()) if tokens}
    counts = {"firings": observer.firings, "drops": observer.drops, "errors": observer.errors}
    if as_json:
        say_json(
            {
                "model": str(outcome.application.source),
                "ending": outcome.ending,
                **counts,
                "restarts": observer.restarts,
                "halted": dict(sorted(observer.halted.items())),
                "missing": outcome.missing,
                "marking": marking,
                "signals": dict(sorted(observer.signals.items())),
                "conformance": verdict.status if verdict is not None else None,
                "traces": str(trace) if trace is not None else None,
            }
        )
        return
    for node in outcome.missing:
        warn(f"node {node} did not start")
    for node, error in sorted(observer.halted.items()):
        warn(f"node {node} is halted by a failure: {error}")
    marked = ", ".join(f"{place} {tokens}" for place, tokens in marking.items())
    say(f"{_ENDINGS[outcome.ending]}; marked: {marked or 'nothing'}")
    if verdict is not None:
        say(f"conformance: {verdict.status}, {counted(verdict.steps, 'step')} replayed")
    told = ", ".join(counted(number, noun.removesuffix("s")) for noun, number in counts.items())
    kept = f"; traces in {trace}" if trace is not None else ""
    summarise(f"{outcome.application.title}: {told}, {counted(observer.restarts, 'restart')}{kept}")
