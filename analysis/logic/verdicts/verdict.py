"""Runs that show the answer to a temporal question, after a replay by the firing rule."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, Step
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import moves

Marking = tuple[int, ...]

MOST_FIRINGS = 10_000
"""Maximum number of firings of a loop that are replayed until atoms keep their values."""


class ReplayError(AssertionError):
    """A witness cannot be replayed: an error of this program, not of the user."""


def replayed(
    net: CompiledNet, stem: Sequence[int], loop: Sequence[int], must_loop: bool = True
) -> tuple[list[Step], list[Step]]:
    """Fire a lasso transition by transition and return the steps of the stem and those of the loop.

    Without a loop, the run must end in a deadlock, which becomes the loop. If no loop is required, the last
    marking may instead be a step without a firing.

    Raises
    ------
    ReplayError
        A transition is not enabled, or the loop does not return to its beginning, or a required loop is
        missing.
    """
    first, start = fired(net, tuple(net.initial.tolist()), stem)
    again, end = fired(net, start, loop)
    if loop and end != start:
        raise ReplayError("the loop of a witness does not return to its first marking")
    if not loop:
        if must_loop and any(moves(net, end)):
            raise ReplayError("a witness without a loop does not end in a deadlock")
        again = [Step(end, None)]
    return first, again


def fired(net: CompiledNet, marking: Marking, transitions: Sequence[int]) -> tuple[list[Step], Marking]:
    """Fire transitions from a marking; return the steps, and the marking after them.

    Raises
    ------
    ReplayError
        One of them is not enabled.
    """
    steps = []
    for transition in transitions:
        if not net.is_enabled(transition, marking):
            raise ReplayError(f"witness fires {net.transitions[transition]!r}, which is not enabled")
        steps.append(Step(marking, transition))
        marking = tuple(net.fire(transition, marking))
    return steps, marking


def settled(
    net: CompiledNet, atoms: BoundAtoms, stem: Sequence[int], loop: Sequence[int]
) -> tuple[list[Step], list[Step]]:
    """Return the steps of a run until its atoms keep their values, and those of one more round of its loop.

    The loop may leave more tokens than it had initially. Then every comparison, and whether a transition is
    enabled, has a constant value from some round on.

    Raises
    ------
    ReplayError
        The run cannot be fired, or its loop cannot be repeated forever.
    """
    if not loop:
        return replayed(net, stem, loop)
    steps, start = fired(net, tuple(net.initial.tolist()), stem)
    more, marking = fired(net, start, loop)
    steps += more
    gains = [after - before for before, after in zip(start, marking, strict=True)]
    grown = {place for place, gain in enumerate(gains) if gain}
    if min(gains, default=0) < 0:
        raise ReplayError("the loop of a witness takes tokens")
    if any(place in grown for t in loop for place, _ in net.inhibitor.row(t)):
        raise ReplayError("what grows in the loop of a witness inhibits it")
    rounds = 1 + _rounds(net, atoms, max(max(step.marking) for step in steps)) if grown else 0
    if rounds * len(loop) > MOST_FIRINGS:
        raise ReplayError("the loop of a witness takes too many rounds until atoms stay as they are")
    for _ in range(rounds):
        more, marking = fired(net, marking, loop)
        steps += more
    first = len(steps) - len(loop)
    return steps[:first], steps[first:]


def _rounds(net: CompiledNet, atoms: BoundAtoms, largest: int) -> int:
    """Number of rounds after which atoms are constant; `largest`: the most tokens on a place in the first."""
    least = max((*net.pre.weight.tolist(), *net.inhibitor.weight.tolist(), 1))
    for condition in atoms.conditions.values():
        if isinstance(condition, Linear):
            there = largest * sum(abs(factor) for factor in condition.factors.values())
            least = max(least, there + abs(condition.bound) + 1)
    return int(least)


def check_counterexample(
    net: CompiledNet,
    formula: Formula,
    atoms: BoundAtoms,
    stem: Sequence[int],
    loop: Sequence[int],
    weak: Sequence[int] = (),
    strong: Sequence[int] = (),
) -> None:
    """Check by definition that a lasso is a fair run of the net on which an LTL formula is false.

    The loop may leave more tokens than it had initially, as for `settled`.

    Raises
    ------
    ReplayError
        It is not.
    """
    first, again = settled(net, atoms, stem, loop)
    if holds_on_lasso(formula, first, again, atoms.is_true):
        raise ReplayError(f"the witness satisfies {formula}")
    if unfair := unfair_to(net, again, weak, strong):
        kind = "strongly" if unfair[0] in strong else "weakly"
        raise ReplayError(f"the witness is not {kind} fair to {net.transitions[unfair[0]]!r}")


def unfair_to(
    net: CompiledNet, again: Sequence[Step], weak: Sequence[int], strong: Sequence[int]
) -> list[int]:
    """Return the weakly and strongly fair transitions that a run neglects when it repeats these steps."""
    fired = {step.transition for step in again}
    enabled = {t: [net.is_enabled(t, step.marking) for step in again] for t in {*weak, *strong} - fired}
    return [t for t in (*weak, *strong) if t in enabled and (any if t in strong else all)(enabled[t])]
