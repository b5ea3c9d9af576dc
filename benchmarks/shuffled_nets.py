"""Each net in ten shuffles with random names: state spaces and behaviour must cost the same.

For each net the processor time of the fastest and of the slowest shuffle, the quotient of the two, which
should be under two, and the same for liveness, reversibility and home markings, which `dineros check` asks
for beside the state space. Kernels are loaded before; each shuffle has a limit of time.

Usage: ``python -m benchmarks.shuffled_nets [words to choose nets by]``.
"""

from __future__ import annotations

import gc
import sys
import time
from contextlib import suppress

from benchmarks.state_spaces import MEMORY, NETS, machine
from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.behaviour import TooMuchWorkError, behaviour
from dineros.analysis.questions.check import CHEAP
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis import classic_nets as classic
from tests.support.shuffled_nets import shuffled

SHUFFLES = 10
SECONDS = 120.0


def measure(net: CompiledNet) -> tuple[float, float, int]:
    """Processor seconds for the state space with all counts, and for the behaviour; most nodes held."""
    gc.collect()  # what others left is no part of it
    began = time.process_time()
    space = symbolic_state_space(net, Budget(MEMORY, seconds=SECONDS).begun())
    for counted in (space.arcs, space.deadlocks, space.largest_place, space.largest_total):
        counted()
    middle = time.process_time()
    with suppress(TooMuchWorkError):
        behaviour(space, work=CHEAP)
    return middle - began, time.process_time() - middle, space.peak_nodes


def main(words: list[str]) -> None:
    """Print the table."""
    measure(classic.philosophers(3))
    print(machine(), end="\n\n")
    print("| net | fastest | slowest | quotient | behaviour, fastest | slowest | quotient | peak nodes |")
    print(f"|{'---|' * 8}")
    for name, make in NETS.items():
        if not all(word in name for word in words):
            continue
        try:
            found = [measure(shuffled(make(), seed)) for seed in range(SHUFFLES)]
        except BudgetExceededError:
            print(f"| {name} | not in {SECONDS:.0f} s |", flush=True)
            continue
        cells = [name]
        for times in ([row[0] for row in found], [row[1] for row in found]):
            cells += [f"{min(times):.3f}", f"{max(times):.3f}", f"{max(times) / min(times):.2f}"]
        nodes = [row[2] for row in found]
        cells.append(f"{min(nodes)} to {max(nodes)}")
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
