"""Size of nets before and after reduction: the case study in all variants, and the classic nets.

Run as ``python -m benchmarks.analysis.reductions [RED BLUE GREEN]``.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import time

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.reductions import Property, ReductionError, reduce
from tests.analysis.reference_case_study import SIGNAL_VARIANTS, reference_case_study


def subjects(objects: tuple[int, int, int]) -> dict[str, CompiledNet]:
    """Name the nets to reduce."""
    nets = {
        f"case study {objects} {v}": reference_case_study(objects, v, "weighted") for v in SIGNAL_VARIANTS
    }
    try:
        classic = importlib.import_module("tests.analysis.classic_nets")
    except ModuleNotFoundError:
        return nets
    for name, make in inspect.getmembers(classic, inspect.isfunction):
        if make.__module__ == classic.__name__ and inspect.signature(make).return_annotation == "CompiledNet":
            nets[f"{name} 5"] = make(5)
    return nets


def main() -> None:
    """Print one line per net and property."""
    objects = tuple(map(int, sys.argv[1:4])) or (1, 1, 1)
    assert len(objects) == 3
    print(
        f"{'net':36} {'preserving':18} {'places':>11} {'transitions':>11} {'steps':>5} {'factor':>6} {'s':>5}"
    )
    for name, net in subjects(objects).items():
        for item in Property:
            start = time.perf_counter()
            reduction = reduce(net, {item})
            seconds = time.perf_counter() - start
            try:
                factor = str(reduction.count_factor)
            except ReductionError:
                factor = "-"
            places = f"{len(net.places)} -> {len(reduction.net.places)}"
            transitions = f"{len(net.transitions)} -> {len(reduction.net.transitions)}"
            print(
                f"{name:36} {item:18} {places:>11} {transitions:>11} {len(reduction.steps):>5}"
                f" {factor:>6} {seconds:5.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
