"""How long flattening takes: 200 node nets joined by 400 topics and 200 services.

Run ``python benchmarks/models/flatten_large.py [--nodes N] [--profile] [--json]``. Each phase is measured
apart; the whole must take less than 30 seconds.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import pstats
import sys
import time
from collections.abc import Callable, Iterator
from functools import wraps
from typing import Any, ParamSpec

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import elements
from dineros.transformations.flattening import flatten as flattening
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.matcher import Matcher

P = ParamSpec("P")
LIMIT = 30.0


def make_model(nodes: int) -> sym.SystemModel:
    """Return a system model: each node net has two signals, sends on two topics and serves its neighbour."""
    model = sym.SystemModel(id="large")
    nets = [_node_net(model, number) for number in range(nodes)]
    for number, net in enumerate(nets):
        for offset in (1, 7):
            _topic(model, net, [nets[(number + offset) % nodes], nets[(number + 2 * offset) % nodes]], offset)
        _service(model, net, [nets[(number + offset) % nodes] for offset in (3, 5)])
    return model


def _node_net(model: sym.SystemModel, number: int) -> sym.NodeNet:
    net = sym.NodeNet(id=f"node{number}", net=model)
    ready, work, done = (
        sym.Place(id=f"{net.id}.ready", tokens=1, page=net),
        sym.Transition(id=f"{net.id}.work", page=net),
        sym.Place(id=f"{net.id}.done", page=net),
    )
    flow(ready, work, done)
    for name in ("go", "stop"):
        sym.InputSignal(id=f"{net.id}.{name}", name=name, node=net)
    set_clause(work, "go & !stop")
    return net


def _topic(model: sym.SystemModel, sender: sym.NodeNet, receivers: list[sym.NodeNet], number: int) -> None:
    channel = sym.TopicChannel(
        id=f"{sender.id}.topic{number}", topic=f"/{sender.id}/topic{number}", model=model
    )
    sent = sym.Place(id=f"{channel.id}.sent", page=sender)
    flow(_work(sender), sent)
    channel.publishers.append(sym.PublisherPort(place=sent))
    for receiver in receivers:
        page = sym.CallbackPage(id=f"{channel.id}@{receiver.id}", page=receiver)
        received = sym.Place(id=f"{page.id}.received", page=page)
        flow(
            received,
            sym.Transition(id=f"{page.id}.handle", page=page),
            pn.ReferencePlace(id=f"{page.id}.onward", target=_done(receiver), page=page),
        )
        channel.subscribers.append(sym.SubscriberPort(place=received))


def _service(model: sym.SystemModel, server: sym.NodeNet, clients: list[sym.NodeNet]) -> None:
    page = sym.CallbackPage(id=f"{server.id}.server", kind="server", page=server)
    entry, exit_ = sym.Place(id=f"{page.id}.entry", page=page), sym.Place(id=f"{page.id}.exit", page=page)
    serve = sym.Transition(id=f"{page.id}.serve", page=page)
    flow(entry, serve, exit_)
    set_clause(serve, "go | stop")
    channel = sym.ServiceChannel(
        id=f"{server.id}.service",
        service=f"/{server.id}/serve",
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        model=model,
    )
    for net in clients:
        request, response = (
            sym.Place(id=f"{channel.id}@{net.id}.{part}", page=net) for part in ("request", "response")
        )
        flow(_work(net), request)
        flow(response, sym.Transition(id=f"{channel.id}@{net.id}.take", page=net), _done(net))
        channel.clients.append(sym.ClientPort(client=net.id, request=request, response=response))


def _work(net: sym.NodeNet) -> sym.Transition:
    return next(node for node in net.objects if isinstance(node, sym.Transition))


def _done(net: sym.NodeNet) -> sym.Place:
    return [node for node in net.objects if isinstance(node, sym.Place)][1]


PHASES: dict[str, list[tuple[object, str]]] = {
    "copy": [(flattening, "deep_copy")],
    "match": [(Matcher, "matches")],
    "create": [(Engine, "_create")],
    "plain net": [(flattening, "_plain_net")],
    "trace": [(flattening, "_trace")],
    "certificate": [(flattening, "add_certificate"), (flattening, "check_certificate")],
}


class Stopwatch:
    """Adds up the seconds spent in functions."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PHASES, 0.0)
        self._running = False

    def watch(self) -> None:
        """Measure the functions of all phases from now on."""
        for phase, functions in PHASES.items():
            for owner, name in functions:
                setattr(owner, name, self._timed(phase, getattr(owner, name)))

    def _timed(self, phase: str, function: Callable[P, Any]) -> Callable[P, Any]:
        @wraps(function)
        def timed(*args: P.args, **kwargs: P.kwargs) -> Any:
            if self._running:  # a phase inside another one counts for the outer one
                return function(*args, **kwargs)
            self._running = True
            start = time.perf_counter()
            try:
                result = function(*args, **kwargs)
                # Matches are found while they are asked for: ask for all of them.
                return iter(list(result)) if isinstance(result, Iterator) else result
            finally:
                self.seconds[phase] += time.perf_counter() - start
                self._running = False

        return timed


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--nodes", type=int, default=200)
    parser.add_argument("--profile", action="store_true", help="print the slowest functions as well")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    model = make_model(arguments.nodes)
    if arguments.profile:
        with cProfile.Profile() as profile:
            flattening.flatten(model)
        pstats.Stats(profile).sort_stats("tottime").print_stats(15)
    stopwatch = Stopwatch()
    stopwatch.watch()
    start = time.perf_counter()
    flattened = flattening.flatten(model)
    total = time.perf_counter() - start
    figures = {**stopwatch.seconds, "rest": total - sum(stopwatch.seconds.values()), "total": total}
    if arguments.json:
        print(json.dumps(figures))
    else:
        print(f"{sum(1 for _ in elements(model))} elements became {len(flattened.trace.links)}")
        for phase, seconds in figures.items():
            print(f"{phase:12} {seconds:6.2f} s {100 * seconds / total:5.1f} %")
        print(f"limit {LIMIT:.0f} s")
    sys.exit(total > LIMIT)


if __name__ == "__main__":
    main()
