"""Shortest ways: what the state equation saves a breadth-first search, in markings and processor seconds.

Each goal is searched for twice, by itself and led by the bound (`dineros.analysis.explicit.guidance`), and
both must find ways of the same length, or only the led search one within the limits.

Usage: ``python -m benchmarks.analysis.shortest_ways [words to choose rows by]``.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial

from benchmarks.analysis.state_spaces import machine
from case_study.build import build
from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Goal, find, find_all
from dineros.analysis.explicit import search as engine
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.transformations.rules.phases import SignalVariant
from tests.analysis import classic_nets as classic

LIMITS = Budget(memory_bytes=4 << 30, states=20_000_000, seconds=60)
SIGNALS: tuple[SignalVariant, ...] = ("none", "input-enabled", "io-enabled", "fully-enabled")


def rows() -> dict[str, tuple[CompiledNet, Goal]]:
    """Return nets and goals by name."""
    found = {}
    for signals in SIGNALS:
        net = subject_of(build(), signals).net
        found[f"case study {signals}: TShowResult"] = net, Goal.enabled(net, "TShowResult")
        found[f"case study {signals}: Shown >= 2"] = net, Goal.where(net, [({"Shown": 1}, ">=", 2)])
    for number in (5, 7, 9):
        net = classic.philosophers(2 * number)
        eating = [({f"eat{one}": 1}, ">=", 1) for one in range(0, 2 * number, 2)]
        found[f"philosophers-{2 * number}: {number} eat"] = net, Goal.where(net, eating)  # type: ignore[arg-type]
    for parts in (4, 5):
        net = classic.kanban(parts)
        goal = Goal.where(net, [({"out4": 1}, ">=", parts), ({"out1": 1}, ">=", parts)])
        found[f"kanban-{parts}: {parts} out of 1 and 4"] = net, goal
    return found


def measured(search: Callable[[], Outcome]) -> tuple[float, int, Outcome]:
    """Return processor seconds, markings, and the answer."""
    seen: list[int] = []
    run = engine.Search.run

    def counting(self: engine.Search) -> None:
        run(self)
        seen.append(self.markings)

    engine.Search.run = counting  # type: ignore[method-assign]
    try:
        began = time.process_time()
        answer = search()
        return time.process_time() - began, sum(seen), answer
    finally:
        engine.Search.run = run  # type: ignore[method-assign]


def unled(net: CompiledNet, goal: Goal) -> Outcome:
    """Search level by level."""
    return find_all(net, [goal], LIMITS)[0]


def length(answer: Outcome) -> str:
    """Return how long a way is, or why there is none."""
    return str(len(answer.trace)) if answer.trace is not None else f"none ({answer.reason or answer.status})"


def main(words: list[str]) -> int:
    """Print the table; 1 where ways differ in length."""
    wrong = False
    print(machine(), end="\n\n")
    print("| goal | steps | markings, led | seconds | markings, by itself | seconds | quotient |")
    print(f"|{'---|' * 7}")
    for name, (net, goal) in rows().items():
        if not all(word in name for word in words):
            continue
        find_all(net, [goal], Budget(states=100))  # kernels are loaded, places laid out
        led, few, short = measured(partial(find, net, goal, LIMITS))
        alone, many, other = measured(partial(unled, net, goal))
        wrong |= other.trace is not None and length(short) != length(other)
        steps = length(short) if length(other) == length(short) else f"{length(short)}; {length(other)}"
        print(
            f"| {name} | {steps} | {few:,} | {led:.3f} | {many:,} | {alone:.3f} | {led / alone:.2f} |",
            flush=True,
        )
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
