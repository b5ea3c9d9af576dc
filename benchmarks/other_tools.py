"""Our engines and Storm's, on the same nets in one run: seconds for markings and arcs, as Markdown.

Storm (C++) counts the states of a net in two ways: with binary decision diagrams, and by storing state by
state. A net becomes a stochastic one with rate 1 for every transition, whose states are the markings, with
the proved bounds as capacities. Each row is a process of its own; reading the net is not counted, kernels
are loaded before the clock starts.

Storm is not a dependency of this project: ``pip install stormpy`` first.

Usage: ``python -m benchmarks.other_tools [words to choose rows by]``.

References
----------
C. Hensel, S. Junges, J.-P. Katoen, T. Quatmann, M. Volk, *The probabilistic model checker Storm*, STTT 24,
2022.
"""

from __future__ import annotations

import importlib
import multiprocessing
import sys
import time
from typing import Any

from benchmarks.analysis.state_spaces import NETS, SMALL, count, machine, warm_up
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import peak_memory
from dineros.analysis.symbolic.levels import encode

ROWS = [*SMALL, "philosophers-20", "fms-10", "case-study-none-1", "case-study-input-1"]
OURS = ("symbolic", "explicit-1", "explicit-2")
#: Beyond an engine that stores state by state.
LARGE = ("philosophers-20", "fms-10")
#: Seconds after which a row is given up.
LIMIT = 200


def to_jani(net: CompiledNet) -> Any:
    """Return a net as Storm's model of it."""
    gspn = importlib.import_module("stormpy.gspn")
    builder = gspn.GspnBuilder()
    bounds = encode(net).bounds
    places = [
        builder.add_place(bound.value if bound else None, int(tokens), f"p{number}")
        for number, (tokens, bound) in enumerate(zip(net.initial, bounds, strict=True))
    ]
    for number in range(len(net.transitions)):
        transition = builder.add_timed_transition(0, 1.0, 1, f"t{number}")
        for place, weight in net.pre.row(number):
            builder.add_input_arc(places[place], transition, weight)
        for place, weight in net.post.row(number):
            builder.add_output_arc(transition, places[place], weight)
        for place, weight in net.inhibitor.row(number):
            builder.add_inhibition_arc(places[place], transition, weight)
    return gspn.build_jani_model(builder.build_gspn())[0]


def measure(name: str, engine: str) -> None:
    """Print one row of the table."""
    net = NETS[name]()
    if engine in OURS:
        warm_up(net, engine)
        began = time.perf_counter()
        markings, arcs, _, _ = count(net, engine)
        seconds = time.perf_counter() - began
    else:
        stormpy = importlib.import_module("stormpy")
        model = to_jani(net)
        build = stormpy.build_symbolic_model if engine == "Storm symbolic" else stormpy.build_model
        began = time.perf_counter()
        space = build(model)
        seconds = time.perf_counter() - began
        markings, arcs = space.nr_states, space.nr_transitions
    print(
        f"| {name} | {engine} | {markings:,} | {arcs:,} | {seconds:.3f} | {peak_memory() >> 20} |", flush=True
    )


def main(words: list[str]) -> int:
    """Print the table."""
    try:
        importlib.import_module("stormpy")
    except ImportError:
        print("Storm is not installed: pip install stormpy", file=sys.stderr)
        return 2
    print(machine(), end="\n\n")
    print("| net | engine | markings | arcs | seconds | peak MiB |\n|---|---|---|---|---|---|")
    context = multiprocessing.get_context("spawn")
    for name in ROWS:
        for engine in ("symbolic", "Storm symbolic", "explicit-1", "explicit-2", "Storm sparse"):
            if name in LARGE and not engine.endswith("symbolic"):
                continue
            if all(word in f"{name} {engine}" for word in words):
                process = context.Process(target=measure, args=(name, engine))
                process.start()
                process.join(LIMIT)
                if process.exitcode is None:
                    process.terminate()
                    process.join()
                    print(f"| {name} | {engine} | | | none in {LIMIT} s | |", flush=True)
                elif process.exitcode:
                    print(f"| {name} | {engine} | | | failed | |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
