"""Each net in ten shuffles with random names: its state space and `check` must cost the same.

For each net the processor time of the fastest and of the slowest shuffle, and the ratio of the two, which
should be under two: for the state space with all counts, and for what `dineros check` asks. Kernels are
loaded before; each shuffle has a limit of processor time.

Usage: ``python -m benchmarks.analysis.shuffled_nets [words to choose nets by]``.
"""

from __future__ import annotations

import gc
import sys
import time

from benchmarks.analysis.state_spaces import MEMORY, NETS, machine
from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.checks.check import check
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import to_model
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis import classic_nets as classic
from tests.support.shuffled_nets import shuffled

SHUFFLES = 10
SECONDS = 120.0
REPEATED, SHORT = 5, 0.1


def measure(net: CompiledNet) -> tuple[float, float, int, tuple[int, int, int]]:
    """Processor seconds for the state space with counts and for `check`; most nodes held; what it said."""
    model = to_model(net, "net")
    gc.collect()  # what others left is not part of it
    gc.freeze()
    began = time.process_time()
    space = symbolic_state_space(net, Budget(MEMORY, seconds=SECONDS).begun())
    for counted in (space.arcs, space.deadlocks, space.largest_place, space.largest_total):
        counted()
    nodes = space.peak_nodes
    middle = time.process_time()
    del space
    asked = time.process_time()
    report = check(model, Budget(MEMORY, seconds=SECONDS))
    said = len(report.findings), len(report.proved), len(report.unknown)
    return middle - began, time.process_time() - asked, nodes, said


def least(net: CompiledNet) -> tuple[float, float, int, tuple[int, int, int]]:
    """As `measure`; of nets that take milliseconds, which a machine's noise can double, the least of some."""
    times = [measure(net)]
    while len(times) < REPEATED and min(times[0][:2]) < SHORT:
        times.append(measure(net))
    return min(row[0] for row in times), min(row[1] for row in times), *times[0][2:]


def main(words: list[str]) -> None:
    """Print the table."""
    # Budgets look at this clock: what else the machine does costs a shuffle nothing.
    time.perf_counter = time.process_time
    measure(classic.philosophers(3))
    print(machine(), end="\n\n")
    print("| net | fastest | slowest | ratio | check, fastest | slowest | quotient | peak nodes | check |")
    print(f"|{'---|' * 9}")
    for name, make in NETS.items():
        if not all(word in name for word in words):
            continue
        try:
            found = [least(shuffled(make(), seed)) for seed in range(SHUFFLES)]
        except BudgetExceededError:
            print(f"| {name} | not in {SECONDS:.0f} s |", flush=True)
            continue
        cells = [name]
        for times in ([row[0] for row in found], [row[1] for row in found]):
            cells += [f"{min(times):.3f}", f"{max(times):.3f}", f"{max(times) / min(times):.2f}"]
        nodes = [row[2] for row in found]
        cells.append(f"{min(nodes)} to {max(nodes)}")
        said = {row[3] for row in found}
        cells.append(" or ".join(f"{one} found, {two} proved, {three} unknown" for one, two, three in said))
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
