"""Generated tests from traces, driven in this process: quicker than pytest in one of its own."""

from __future__ import annotations

import importlib
import random
import runpy
import sys
from collections.abc import Sequence
from pathlib import Path

from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.witnesses.records import witness_records
from dineros.analysis.witnesses.witness import witness_of
from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.records import write_records


def write_walk(model: sym.SystemModel, path: Path, seed: int, steps: int = 25) -> int:
    """Write a random firing sequence of a model as a witness; return its length."""
    subject, choose = base_subject(model), random.Random(seed)
    net, trace = subject.net, list[int]()
    marking = net.initial.tolist()
    while len(trace) < steps and max(marking) < 50:
        enabled = [number for number in range(len(net.transitions)) if net.is_enabled(number, marking)]
        if not enabled:
            break
        trace.append(choose.choice(enabled))
        marking = net.fire(trace[-1], marking)
    write_witness(subject, trace, path)
    return len(trace)


def write_witness(subject: Subject, trace: Sequence[int], path: Path) -> None:
    """Write a firing sequence, by numbers of transitions, as a witness."""
    write_records(path, list(witness_records(witness_of(subject, trace), source="model")))


def drive(model: sym.SystemModel, trace: Path, folder: Path) -> None:
    """Generate a workspace with a test from a trace, and do what the test does.

    Raises
    ------
    AssertionError
        A step cannot be done, or the marking at the end is another one.
    """
    generate(model, folder, Options(source="model", tests=(trace,)))
    (tests,) = (folder / "src").glob("*_bringup/test")
    (test,) = tests.glob("test_*.py")
    modules, path = set(sys.modules), list(sys.path)
    sys.path[:0] = [str(package) for package in (folder / "src").iterdir()]
    importlib.invalidate_caches()
    try:
        script, driver = runpy.run_path(str(test)), runpy.run_path(str(tests / "conftest.py"))["Driver"]()
        try:
            driver.go(script["STEPS"])
            found = driver.marking()
        finally:
            driver.close()
        wanted = script["MARKING"]
        assert {place: found.get(place, 0) for place in wanted} == wanted
    finally:
        sys.path[:] = path
        for name in set(sys.modules) - modules:
            if not name.startswith("dineros."):
                del sys.modules[name]
