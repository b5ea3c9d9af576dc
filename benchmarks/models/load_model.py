"""How long saving, loading and validating a system model of 20 000 elements takes.

Run ``python benchmarks/models/load_model.py [--elements N] [--json]``. The aim: loading and validating
together take less than 10 seconds.
"""

from __future__ import annotations

import argparse
import gc
import json
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import elements
from dineros.metamodel.files import load, save

T = TypeVar("T")
AIM_SECONDS = 10.0


def make_model(size: int) -> sym.SystemModel:
    """Return a valid system model with at least `size` elements: node nets joined by topics and services."""
    model = sym.SystemModel(id="benchmark")
    count = 1
    number = 0
    previous: sym.Place | None = None
    server: sym.NodeNet | None = None
    while count < size:
        net = sym.NodeNet(id=f"node{number}", net=model)
        net.signals.append(sym.InputSignal(id=f"signal{number}", node=net))
        count += 2
        for row in range(20):
            stem = f"n{number}_{row}"
            start, end = _place(net, f"{stem}_start", 40 * row), _place(net, f"{stem}_end", 40 * row)
            start.tokens = 1
            work = sym.Transition(id=f"{stem}_work", graphics=_at(100, 40 * row), page=net)
            flow(start, work, end)
            count += 5
        set_clause(work, f"signal{number} | !signal{number}")
        page = sym.CallbackPage(id=f"callback{number}", page=net)
        received = _place(page, f"received{number}", 0)
        take = sym.Transition(id=f"take{number}", page=page)
        flow(received, take, pn.ReferencePlace(id=f"onward{number}", target=start, page=page))
        count += 6
        if previous is not None:
            channel = sym.TopicChannel(id=f"topic{number}", topic=f"/topic{number}", model=model)
            channel.publishers.append(sym.PublisherPort(place=previous))
            channel.subscribers.append(sym.SubscriberPort(place=received))
            count += 1
        if server is not None:
            count += _add_service(model, server, net, number)
        previous, server, number = end, net, number + 1
    return model


def _add_service(model: sym.SystemModel, server: sym.NodeNet, client: sym.NodeNet, number: int) -> int:
    """Let a node net call the one before it; return the number of elements made."""
    page = sym.CallbackPage(id=f"server{number}", kind="server", page=server)
    entry, leave = _place(page, f"entry{number}", 0), _place(page, f"exit{number}", 0)
    flow(entry, sym.Transition(id=f"serve{number}", page=page), leave)
    request, response = _place(client, f"request{number}", 0), _place(client, f"response{number}", 0)
    sink = sym.Transition(id=f"ask{number}", page=client)
    flow(_first_place(client), sink, request)
    flow(response, sym.Transition(id=f"finish{number}", page=client), _first_place(client))
    sym.ServiceChannel(
        id=f"service{number}",
        service=f"/service{number}",
        server=sym.ServerPort(entry=entry, exit=leave, page=page),
        clients=[sym.ClientPort(client="only", request=request, response=response)],
        model=model,
    )
    return 15


def _first_place(net: sym.NodeNet) -> sym.Place:
    return next(node for node in net.objects if isinstance(node, sym.Place))


def _place(page: pn.Page, id: str, y: float) -> sym.Place:
    return sym.Place(id=id, graphics=_at(0, y), page=page)


def _at(x: float, y: float) -> pn.Graphics:
    return pn.Graphics(positions=[pn.Point(x=float(x), y=float(y))])


class Stopwatch:
    """Collects how long pieces of work take."""

    def __init__(self) -> None:
        self.figures: dict[str, float] = {}

    def time(self, name: str, work: Callable[[], T]) -> T:
        """Return what a piece of work returns, and note its seconds."""
        start = time.perf_counter()
        result = work()
        self.figures[name] = time.perf_counter() - start
        return result


def measure(size: int) -> dict[str, float]:
    """Return the seconds that each step takes for a model of `size` elements."""
    watch = Stopwatch()
    model = watch.time("make", partial(make_model, size))
    watch.figures["elements"] = sum(1 for _ in elements(model))
    with tempfile.TemporaryDirectory() as folder:
        paths = {suffix: Path(folder, f"model.{suffix}") for suffix in ("pnml", "xmi")}
        for suffix, path in paths.items():
            watch.time(f"save {suffix}", partial(save, model, path))
            watch.figures[f"MB of {suffix}"] = path.stat().st_size / 1e6
        # A user loads one model; others in memory would make the garbage collector look longer.
        del model
        gc.collect()
        watch.time("load pnml", partial(load, paths["pnml"]))
        gc.collect()
        loaded = watch.time("load xmi", partial(load, paths["xmi"]))
        found = watch.time("validate", partial(validate, loaded))
    assert not [violation for violation in found if violation.severity == "error"], found[:3]
    return watch.figures


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--elements", type=int, default=20_000)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    figures = measure(arguments.elements)
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:12} {value:10.2f}")
    together = figures["load xmi"] + figures["validate"]
    print(f"load and validate: {together:.2f} s, aim {AIM_SECONDS:.0f} s")


if __name__ == "__main__":
    main()
