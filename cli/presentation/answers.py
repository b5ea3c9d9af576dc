"""Prints the answer to a question about a net, with its witness."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from dineros.cli.analysing import say_witness
from dineros.cli.console import note, say, summarise, warn
from dineros.metamodel.errors import counted

MOST_NAMES = 5
"""Limit of the transitions named in one line."""
_HOLDS = "this answer also holds with times"
_NEED_NOT_HOLD = "with times this answer may not hold: the run may be impossible"

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.model.fairness import Unfairness
    from dineros.analysis.model.times import LeftOutTimes
    from dineros.analysis.questions.needed_fairness import NeededFairness
    from dineros.analysis.witnesses.witness import Witness


def say_way(answer: Outcome, goal: str, witness: Witness | None, model: Path, output: Path | None) -> None:
    """Print whether a goal is reached, and its firing sequence unless that was written to a file."""
    seen = f"; {counted(answer.states, 'state')}" if answer.states is not None else ""
    say(f"{answer.status}: {goal}{_reason(answer)}{seen}")
    _note_who(answer)
    if witness and output is None:
        say_witness(witness)
    elif witness:
        summarise(f"{model} -> {output}: {counted(len(witness.steps), 'step')}")


def say_verdict(
    verdict: Outcome,
    formula: str,
    witness: Witness | None,
    model: Path,
    output: Path | None,
    *,
    is_linear: bool,
) -> None:
    """Print whether a formula holds, and the run that shows it unless that was written to a file."""
    seen = f"{counted(verdict.states, 'state')}, " if verdict.states is not None else ""
    say(f"{verdict.status}: {formula}{_reason(verdict)}; {seen}{verdict.seconds:.1f} s")
    _note_who(verdict)
    if output is not None and not witness:
        warn(f"{output} is not written: there is no run to show")
    elif witness and output is not None:
        summarise(f"{model} -> {output}: {counted(len(witness.steps), 'step')}")
    elif witness:
        say_witness(witness)
        if is_linear and witness.loop is None and not verdict.reason and not verdict.ends_at_fault:
            say("  then no transition is enabled")


def say_unfairness(unfair: Unfairness, names: Sequence[str]) -> None:
    """Print the transitions to which a repeating run is unfair, by the names of --fair."""
    for transitions, meaning, option in (
        (unfair.weakly, "enabled forever", "--fair"),
        (unfair.strongly, "enabled again and again", "--strongly-fair"),
    ):
        if transitions:
            shown = ", ".join(names[transition] for transition in transitions[:MOST_NAMES])
            more = f" and {len(transitions) - MOST_NAMES} more" if len(transitions) > MOST_NAMES else ""
            say(f"  {meaning}, never fired ({option} leaves such runs out): {shown}{more}")


def say_needed_fairness(needed: NeededFairness) -> None:
    """If only unfair runs violate a formula: print the options with which it holds."""
    options = [f"--fair {quote(name)}" for name in needed.weak]
    options += [f"--strongly-fair {quote(name)}" for name in needed.strong]
    say(f"  only unfair runs violate it: it holds with {' '.join(options)}")


def _note_who(answer: Outcome) -> None:
    """Print with `-v` which engine has answered, and its evidence."""
    if answer.by and answer.status != "unknown":
        note(f"answered by: {answer.by}{f'; {answer.evidence}' if answer.evidence else ''}")


def _reason(answer: Outcome) -> str:
    return f" ({answer.reason})" if answer.reason else ""


def say_times(times: LeftOutTimes | None, text: str) -> None:
    """Print that times are ignored, and the consequences; nothing for a net without times."""
    if times is not None:
        say(f"note: {times}; {text}")


def answer_and_times(times: LeftOutTimes, is_universal: bool) -> str:
    """Return in words whether an answer holds with times."""
    return _HOLDS if times.survives(is_universal) else _NEED_NOT_HOLD


def times_fields(times: LeftOutTimes | None, is_universal: bool | None) -> dict[str, object]:
    """Return for JSON that times are ignored, and whether the answer holds with them."""
    if times is None:
        return {}
    holds = None if is_universal is None else times.survives(is_universal)
    return {"times": {"left_out": str(times), "transitions": times.count, "holds_with_times": holds}}


def say_assumes(assumes: Iterable[str]) -> None:
    """Print the assumptions of an answer."""
    for each in assumes:
        say(f"assumes: {each}")


def assumes_field(assumes: Sequence[str]) -> dict[str, object]:
    """Return the assumptions of an answer for JSON, if there are any."""
    return {"assumes": list(assumes)} if assumes else {}
