"""The place invariants that the rules guarantee; they are added to each flattened net and checked on it.

An invariant is a weighted sum of tokens that no firing changes. The check needs only the incidence
matrix and the initial marking, so it is independent of the rules (Murata, Proc. IEEE 77(4), 1989, Sect. V).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.groups import members_of, works_on_goals
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import label
from dineros.metamodel.errors import DinerosError
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules import (
    coming_and_going,
    executors,
    histories,
    lifecycle,
    requests,
    services,
    signals,
    timers,
)
from dineros.transformations.rules.actions import goals, slots
from dineros.transformations.rules.clients import answers, cancels, living
from dineros.transformations.rules.clients import goals as many_goals
from dineros.transformations.rules.notation import Bound, History, OverflowQueue
from dineros.transformations.rules.times import latencies, orders, strikes, time_outs
from dineros.transformations.rules.times.clocks import Clock


class CertificateError(DinerosError):
    """A flattened net lacks a place invariant that its rules guarantee: a fault in a rule."""


class _Sum(NamedTuple):
    """A weighted sum of tokens that no firing changes: its name, its value, and its places with weights."""

    name: str
    value: int
    terms: Iterable[tuple[EObject, int]]


def add_certificate(
    net: pnm.PetriNetModel, engine: Engine, made: Mapping[EObject, EObject]
) -> list[pnm.PlaceInvariant]:
    """Add the invariants of the elements that the rules made to a net; return the invariants."""
    kinds = (
        *(_queues, _bounds, _instances, _clients, _requests, _slots, _goals, _goal_histories),
        *(
            _signals,
            _disjunctions,
            _timers,
            _clocks,
            _executors,
            _orders,
            _time_outs,
            _groups,
            _managed,
            _kept,
        ),
    )
    certificate = [_invariant(each, made) for kind in kinds for each in kind(engine)]
    net.certificate.extend(certificate)
    return certificate


def _invariant(guaranteed: _Sum, made: Mapping[EObject, EObject]) -> pnm.PlaceInvariant:
    summands = []
    for place, weight in guaranteed.terms:
        image = made[place]
        assert isinstance(image, pn.Place)
        summands.append(pnm.InvariantTerm(place=image, weight=weight))
    return pnm.PlaceInvariant(name=guaranteed.name, value=guaranteed.value, terms=summands)


def _queues(engine: Engine) -> Iterator[_Sum]:
    seen: set[EObject] = set()
    for _, queue in (*engine.groups(OverflowQueue), *engine.groups(History)):
        load, capacity = queue["load"], queue["capacity"]
        if load in seen:  # the instances of a server page share a queue
            continue
        seen.add(load)
        assert isinstance(load, pn.Place) and isinstance(capacity, pn.Place)
        yield _Sum(f"{load.id} + {capacity.id}", capacity.tokens, [(load, 1), (capacity, 1)])


def _bounds(engine: Engine) -> Iterator[_Sum]:
    for application, bound in engine.groups(Bound):
        place, free = bound["place"], bound["free"]
        assert isinstance(place, pn.Place) and isinstance(free, pn.Place)
        name, value, terms = f"{place.id} + {free.id}", place.tokens + free.tokens, [place, free]
        if application.rule is cancels.A8MoreRoom:  # each goal under way makes room
            client = next(each for each in application.sources if isinstance(each, sym.ActionClientPort))
            (sent,) = engine.applications_of(goals.A1, [client])
            ready = sent.made["ready"]
            assert isinstance(ready, pn.Place)
            name, value, terms = f"{name} + {ready.id}", value + ready.tokens, [*terms, ready]
        yield _Sum(name, value, [(each, 1) for each in terms])


def _instances(engine: Engine) -> Iterator[_Sum]:
    return _either(engine, services.S3, "active", "inactive")


def _signals(engine: Engine) -> Iterator[_Sum]:
    yield from _either(engine, signals.I4, "true", "false")
    of: dict[EObject, list[EObject]] = {}
    for application in engine.applications_of(signals.I4Values):
        of.setdefault(application.sources[0], []).append(application.made["holds"])
    for places in of.values():
        yield _Sum(f"{' or '.join(map(_id, places))}", 1, [(place, 1) for place in places])


def _timers(engine: Engine) -> Iterator[_Sum]:
    return _either(engine, timers.C1, "idle", "due")


def _either(engine: Engine, rule: type[Rule], one: str, other: str) -> Iterator[_Sum]:
    """One of two places made by a rule has a token."""
    for application in engine.applications_of(rule):
        place = application.made[one]
        yield _Sum(f"{_id(place)} or {other}", 1, [(place, 1), (application.made[other], 1)])


def _clients(engine: Engine) -> Iterator[_Sum]:
    for application in engine.applications_of(services.S1):
        client = next(source for source in application.sources if isinstance(source, sym.ClientPort))
        if client.outstanding == UNLIMITED:  # rules G4 and R8 remove the place of its readiness
            continue
        call = [application.made[role] for role in ("ready", "requests", "responses")]
        call += [used.made["in_use"] for used in engine.applications_of(services.S2, [client])]
        for kept in engine.applications_of(requests.R5Client, [client]):
            call += [kept.made["sent"], kept.made["lost"]]
        call += _under_way(engine, client)
        ready = call[0]
        assert isinstance(ready, pn.Place)
        words = "one request" if ready.tokens == 1 else f"{ready.tokens} requests"
        yield _Sum(f"{ready.id} or {words} under way", ready.tokens, [(each, 1) for each in call])


def _under_way(engine: Engine, client: sym.ClientPort) -> Iterator[EObject]:
    """Yield the places of requests and responses of a client that are under way, with times."""
    for rule, role in ((latencies.D6, "sent"), (latencies.D6History, "sent"), (latencies.D6Back, "answered")):
        for application in engine.applications_of(rule, [client]):
            yield application.made[role]
    for clock in (latencies.D6Clock, latencies.D6BackClock):
        for application in engine.applications_of(clock, [client]):
            yield application.made["clock.busy"]


def _clocks(engine: Engine) -> Iterator[_Sum]:
    """Each clock runs or is free; the first tick of a timer has happened or has not."""
    yield from _either(engine, strikes.D1, "start", "clock")
    for _, clock in engine.groups(Clock):
        free, busy = clock["free"], clock["busy"]
        yield _Sum(f"{_id(free)} or busy", 1, [(free, 1), (busy, 1)])


def _requests(engine: Engine) -> Iterator[_Sum]:
    """Requests in a history belong to its clients, or to no client if theirs have given up."""
    for application in engine.applications_of(requests.R5):
        (service,) = application.sources
        load = application.made["load"]
        assert isinstance(load, pn.Place)
        held = [each.made["requests"] for each in engine.applications_of(services.S1, [service])]
        for live in engine.applications_of(living.R6Live, [service]):
            terms = [(live.made["live"], 1), *((place, -1) for place in held)]
            yield _Sum(f"{_id(live.made['live'])} counts requests", 0, terms)
        held += [each.made["late"] for each in engine.applications_of(requests.R6, [service])]
        terms = [(load, 1), *((place, -1) for place in held)]
        yield _Sum(f"{load.id} counts requests", 0, terms)


def _slots(engine: Engine) -> Iterator[_Sum]:
    """A slot is in one state, and has the goal of one client."""
    for application in engine.applications_of(slots.A7):
        idle, executing = application.made["idle"], application.made["executing"]
        assert isinstance(idle, pn.Place)
        states = [idle, executing]
        for rule, role in ((slots.A7Ask, "asked"), (slots.A7Cancel, "canceling")):
            states += [each.made[role] for each in engine.applications_of(rule, application.sources)]
        owners = [each.made["in_use"] for each in engine.applications_of(goals.A2, application.sources)]
        yield _Sum(f"{idle.id} or a goal", 1, [(each, 1) for each in states])
        yield _Sum(f"{idle.id} or a client's", 1, [(each, 1) for each in (idle, *owners)])


def _goals(engine: Engine) -> Iterator[_Sum]:
    for application in engine.applications_of(goals.A1):
        client = next(each for each in application.sources if isinstance(each, sym.ActionClientPort))
        if client.outstanding == UNLIMITED:
            continue
        way = [application.made[role] for role in ("ready", "requested")]
        for rule, role in ((goals.A2, "in_use"), (goals.A1Result, "result"), (goals.A2Reject, "refused")):
            way += [each.made[role] for each in engine.applications_of(rule, [client])]
        for kept, role in ((many_goals.G1Client, "sent"), (many_goals.G1Lost, "lost")):
            way += [each.made[role] for each in engine.applications_of(kept, [client])]
        ready = way[0]
        assert isinstance(ready, pn.Place)
        words = "one goal" if ready.tokens == 1 else f"{ready.tokens} goals"
        yield _Sum(f"{ready.id} or {words} under way", ready.tokens, [(each, 1) for each in way])


def _goal_histories(engine: Engine) -> Iterator[_Sum]:
    """The goals, results and answers in a history are the sum of their kinds."""
    for whole, part, role in (
        (many_goals.G1, goals.A1, "requested"),
        (many_goals.G2, many_goals.G2Result, "kept"),
        (answers.G3, answers.G3Accepted, "kept"),
    ):
        for application in engine.applications_of(whole):
            load = application.made["load"]
            held = [each.made[role] for each in engine.applications_of(part, application.sources)]
            if whole is answers.G3:
                refused = engine.applications_of(answers.G3Refused, application.sources)
                held += [each.made[role] for each in refused]
            yield _Sum(f"{_id(load)} counts", 0, [(load, 1), *((place, -1) for place in held)])


def _disjunctions(engine: Engine) -> Iterator[_Sum]:
    values = {application.sources[0]: application.made for application in engine.applications_of(signals.I4)}
    holding = {each.sources[1]: each.made["holds"] for each in engine.applications_of(signals.I4Values)}
    for application in engine.applications_of(signals.I1):
        disjunction = next(source for source in application.sources if isinstance(source, sym.Disjunction))
        place = application.made["true_literals"]
        assert isinstance(place, pn.Place)
        terms: list[tuple[EObject, int]] = [(place, 1)]
        for literal in disjunction.literals:
            if literal.value is None:
                terms.append((values[literal.signal]["false" if literal.negated else "true"], -1))
                continue
            others = [
                each for each in literal.signal.values if (each.name == literal.value) is not literal.negated
            ]
            terms += [(holding[each], -1) for each in others]
        yield _Sum(f"{place.id} counts true literals", 0, terms)


def _executors(engine: Engine) -> Iterator[_Sum]:
    for application in engine.applications_of(executors.E1):
        threads = application.made["threads"]
        running = [each.made["running"] for each in engine.applications_of(executors.E3, application.sources)]
        assert isinstance(threads, pn.Place)
        terms = [(place, 1) for place in (threads, *running)]
        yield _Sum(f"{threads.id} or callbacks that run", threads.tokens, terms)


def _orders(engine: Engine) -> Iterator[_Sum]:
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
        yield _Sum(f"{_id(turn['out'])} or its turn", 1, [(place, 1) for place in places])
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
        yield _Sum(f"{_id(chooser)} or a callback it takes", 1, [(each, 1) for each in (chooser, *places)])
        yield _Sum(f"{_id(unsure)} counts", 0, [(unsure, 1), *((each, -1) for each in ended[node])])
        results = [each.made["now"] for each in engine.applications_of(orders.E8Result, [node])]
        yield _Sum(f"{_id(results[0])} or the other", 1, [(each, 1) for each in results])
    for counter, places in waiting.items():
        yield _Sum(f"{_id(counter)} counts", 0, [(counter, 1), *((each, -1) for each in places)])


def _time_outs(engine: Engine) -> Iterator[_Sum]:
    """The time-out of a client runs exactly while the client is not ready."""
    for application in engine.applications_of(time_outs.D8):
        client = next(source for source in application.sources if isinstance(source, sym.ClientPort))
        (call,) = engine.applications_of(services.S1, [client])
        asks, ready = application.made["asks"], call.made["ready"]
        yield _Sum(f"{_id(ready)} or its time runs", 1, [(ready, 1), (asks, 1)])


def _groups(engine: Engine) -> Iterator[_Sum]:
    for application, group in engine.groups(executors.Lock):
        lock = group["lock"]
        assert isinstance(lock, pn.Place)
        terms: list[tuple[EObject, int]] = [(lock, 1)]
        for member in members_of(application.sources[0]):
            if isinstance(member, sym.CallbackPage) and works_on_goals(member):
                continue
            for rule, role in ((executors.E3, "running"), (executors.E7, "awaiting")):
                terms.extend((each.made[role], 1) for each in engine.applications_of(rule, [member]))
        yield _Sum(f"{lock.id} or a callback that has begun", 1, terms)


def _managed(engine: Engine) -> Iterator[_Sum]:
    """A managed node is in one state, and is configured in two of them."""
    for application in engine.applications_of(lifecycle.L1):
        node, place = label(application.sources[0]), application.made
        states = [place[role] for role in ("unconfigured", "inactive", "active", "finalized")]
        yield _Sum(f"{node} is in one state", 1, [(state, 1) for state in states])
        configured = place["configured"]
        yield _Sum(f"{node} is configured or not", 1, [(configured, 1), (place["away"], 1)])
        terms = [(states[1], 1), (states[2], 1), (configured, -1)]
        yield _Sum(f"{node} is configured while inactive or active", 0, terms)
    for application in engine.applications_of(lifecycle.L1Shutdown):
        (own,) = engine.applications_of(lifecycle.L1, application.sources[:1])
        terms = [(application.made["existing"], 1), (own.made["finalized"], 1)]
        yield _Sum(f"{label(application.sources[0])} exists or is finalized", 1, terms)


def _kept(engine: Engine) -> Iterator[_Sum]:
    """A message that a writer keeps for a restarting reader is delivered or not yet delivered."""
    for application in engine.applications_of(coming_and_going.L5):
        place, limit = application.made, application.sources[1].limit
        for one, other in (("delivered", "undelivered"), ("kept", "room")):
            terms = [(place[one], 1), (place[other], 1)]
            yield _Sum(f"{_id(place[one])} + {_id(place[other])}", limit, terms)
        (written,) = engine.applications_of(histories.R2, application.sources[1:3])
        terms = [(place["kept"], 1), (place["delivered"], -1), (written.made["queue.load"], -1)]
        yield _Sum(f"{_id(place['kept'])} is delivered or to be", 0, terms)


def _id(place: EObject) -> str:
    assert isinstance(place, pn.Place)
    return str(place.id)


def check_certificate(net: pnm.PetriNetModel) -> None:
    """Check all invariants of a net on its incidence matrix and initial marking.

    Raises
    ------
    CertificateError
        An invariant does not hold; the message names it and the transition or marking that breaks it.
    """
    change: dict[pn.Node, dict[pn.Node, int]] = {}
    for page in net.pages:
        for arc in page.arcs:
            if arc.kind != pn.ArcKind.normal:
                continue
            into = isinstance(arc.target, pn.Place)
            place, transition = (arc.target, arc.source) if into else (arc.source, arc.target)
            row = change.setdefault(place, {})
            row[transition] = row.get(transition, 0) + (arc.weight if into else -arc.weight)
    for invariant in net.certificate:
        _check(invariant, change)


def _check(invariant: pnm.PlaceInvariant, change: Mapping[pn.Node, Mapping[pn.Node, int]]) -> None:
    total = 0
    effect: dict[pn.Node, int] = {}
    for term in invariant.terms:
        total += term.weight * term.place.tokens
        for transition, tokens in change.get(term.place, {}).items():
            effect[transition] = effect.get(transition, 0) + term.weight * tokens
    if total != invariant.value:
        raise CertificateError(
            f"place invariant {invariant.name!r} is {total} at the start, not {invariant.value}",
            hint="a rule makes a wrong initial marking",
        )
    for transition, tokens in effect.items():
        if tokens:
            raise CertificateError(
                f"firing {transition.id} changes the place invariant {invariant.name!r} by {tokens}",
                element=transition.id,
                hint="a rule has too few or too many arcs",
            )
