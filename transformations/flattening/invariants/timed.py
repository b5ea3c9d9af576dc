"""The place invariants that the rules about times guarantee."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.transformations.flattening.invariants.common import Sum, either, id_of
from dineros.transformations.language.engine import Engine
from dineros.transformations.rules import executors, services
from dineros.transformations.rules.times import latencies, orders, strikes, time_outs
from dineros.transformations.rules.times.clocks import Clock


def calls_under_way(engine: Engine, client: sym.ClientPort) -> Iterator[EObject]:
    """Yield the places of requests and responses of a client that are under way, with times."""
    for rule, role in ((latencies.D6, "sent"), (latencies.D6History, "sent"), (latencies.D6Back, "answered")):
        for application in engine.applications_of(rule, [client]):
            yield application.made[role]
    for clock in (latencies.D6Clock, latencies.D6BackClock):
        for application in engine.applications_of(clock, [client]):
            yield application.made["clock.busy"]


def of_clocks(engine: Engine) -> Iterator[Sum]:
    """Each clock runs or is free; the first tick of a timer has happened or has not."""
    yield from either(engine, strikes.D1, "start", "clock")
    for _, clock in engine.groups(Clock):
        free, busy = clock["free"], clock["busy"]
        yield Sum(f"{id_of(free)} or busy", 1, [(free, 1), (busy, 1)])


def of_orders(engine: Engine) -> Iterator[Sum]:
    """Each callback that an executor takes in order is in one state; wait results count their callbacks."""
    taken: dict[EObject, list[EObject]] = {}
    ended: dict[EObject, list[EObject]] = {}
    waiting: dict[EObject, list[EObject]] = {}
    for application, turn in engine.groups(orders.Turn):
        page, node = application.sources[:2]
        listings = [
            (each, listing["waits"])
            for each, listing in engine.groups(orders.Listing)
            if page in each.sources
        ]
        running = [each.made["running"] for each in engine.applications_of(executors.E3, [page])]
        places = [turn["out"], turn["taken"], turn["ended"], *running, *(place for _, place in listings)]
        yield Sum(f"{id_of(turn['out'])} or its turn", 1, [(place, 1) for place in places])
        taken.setdefault(node, []).append(turn["taken"])
        ended.setdefault(node, []).append(turn["ended"])
        for each, place in listings:
            role = "messages" if each.rule is orders.E8Message else "timers"
            (number,) = (source for source in each.sources if isinstance(source, int))
            for result in engine.applications_of(orders.E8Result, [node, number]):
                waiting.setdefault(result.made[role], []).append(place)
    for node, places in taken.items():
        (one,) = engine.applications_of(orders.E8, [node])
        chooser, unsure = one.made["chooser"], one.made["unsure"]
        yield Sum(f"{id_of(chooser)} or a callback it takes", 1, [(each, 1) for each in (chooser, *places)])
        yield Sum(f"{id_of(unsure)} counts", 0, [(unsure, 1), *((each, -1) for each in ended[node])])
        results = [each.made["now"] for each in engine.applications_of(orders.E8Result, [node])]
        yield Sum(f"{id_of(results[0])} or the other", 1, [(each, 1) for each in results])
    for counter, places in waiting.items():
        yield Sum(f"{id_of(counter)} counts", 0, [(counter, 1), *((each, -1) for each in places)])


def of_time_outs(engine: Engine) -> Iterator[Sum]:
    """The time-out of a client runs exactly while the client is not ready."""
    for application in engine.applications_of(time_outs.D8):
        client = next(source for source in application.sources if isinstance(source, sym.ClientPort))
        (call,) = engine.applications_of(services.S1, [client])
        asks, ready = application.made["asks"], call.made["ready"]
        yield Sum(f"{id_of(ready)} or its time runs", 1, [(ready, 1), (asks, 1)])
