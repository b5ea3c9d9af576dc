"""The place invariants that the rules of each middleware guarantee."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import UNLIMITED
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules import requests, services, signals
from dineros.transformations.rules.actions import goals, slots
from dineros.transformations.rules.clients import cancels
from dineros.transformations.rules.clients import goals as many_goals
from dineros.transformations.rules.notation import Bound, History, OverflowQueue


class Sum(NamedTuple):
    """A weighted sum of tokens that no firing changes: its name, its value, and its places with weights."""

    name: str
    value: int
    terms: Iterable[tuple[EObject, int]]


def of_queues(engine: Engine) -> Iterator[Sum]:
    """A queue holds messages or has room."""
    seen: set[EObject] = set()
    for _, queue in (*engine.groups(OverflowQueue), *engine.groups(History)):
        load, capacity = queue["load"], queue["capacity"]
        if load in seen:  # the instances of a server page share a queue
            continue
        seen.add(load)
        assert isinstance(load, pn.Place) and isinstance(capacity, pn.Place)
        yield Sum(f"{load.id} + {capacity.id}", capacity.tokens, [(load, 1), (capacity, 1)])


def of_bounds(engine: Engine) -> Iterator[Sum]:
    """A place holds tokens or has room."""
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
        yield Sum(name, value, [(each, 1) for each in terms])


def of_instances(engine: Engine) -> Iterator[Sum]:
    """An instance of a server is active or not."""
    return either(engine, services.S3, "active", "inactive")


def of_signals(engine: Engine) -> Iterator[Sum]:
    """A signal has one of its values."""
    yield from either(engine, signals.I4, "true", "false")
    of: dict[EObject, list[EObject]] = {}
    for application in engine.applications_of(signals.I4Values):
        of.setdefault(application.sources[0], []).append(application.made["holds"])
    for places in of.values():
        yield Sum(f"{' or '.join(map(id_of, places))}", 1, [(place, 1) for place in places])


def of_clients(
    engine: Engine, with_times: Callable[[Engine, sym.ClientPort], Iterable[EObject]] = lambda *_: ()
) -> Iterator[Sum]:
    """A client is ready, or its requests are under way."""
    for application in engine.applications_of(services.S1):
        client = next(source for source in application.sources if isinstance(source, sym.ClientPort))
        if client.outstanding == UNLIMITED:  # rules G4 and R8 remove the place of its readiness
            continue
        call = [application.made[role] for role in ("ready", "requests", "responses")]
        call += [used.made["in_use"] for used in engine.applications_of(services.S2, [client])]
        for kept in engine.applications_of(requests.R5Client, [client]):
            call += [kept.made["sent"], kept.made["lost"]]
        call += with_times(engine, client)
        ready = call[0]
        assert isinstance(ready, pn.Place)
        words = "one request" if ready.tokens == 1 else f"{ready.tokens} requests"
        yield Sum(f"{ready.id} or {words} under way", ready.tokens, [(each, 1) for each in call])


def of_slots(engine: Engine) -> Iterator[Sum]:
    """A slot is in one state, and has the goal of one client."""
    for application in engine.applications_of(slots.A7):
        idle, executing = application.made["idle"], application.made["executing"]
        assert isinstance(idle, pn.Place)
        states = [idle, executing]
        for rule, role in ((slots.A7Ask, "asked"), (slots.A7Cancel, "canceling")):
            states += [each.made[role] for each in engine.applications_of(rule, application.sources)]
        owners = [each.made["in_use"] for each in engine.applications_of(goals.A2, application.sources)]
        yield Sum(f"{idle.id} or a goal", 1, [(each, 1) for each in states])
        yield Sum(f"{idle.id} or a client's", 1, [(each, 1) for each in (idle, *owners)])


def of_goals(engine: Engine) -> Iterator[Sum]:
    """A client of an action is ready, or its goals are under way."""
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
        yield Sum(f"{ready.id} or {words} under way", ready.tokens, [(each, 1) for each in way])


def of_disjunctions(engine: Engine) -> Iterator[Sum]:
    """A place counts the literals of a disjunction that are true."""
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
        yield Sum(f"{place.id} counts true literals", 0, terms)


def either(engine: Engine, rule: type[Rule], one: str, other: str) -> Iterator[Sum]:
    """One of two places made by a rule has a token."""
    for application in engine.applications_of(rule):
        place = application.made[one]
        yield Sum(f"{id_of(place)} or {other}", 1, [(place, 1), (application.made[other], 1)])


def id_of(place: EObject) -> str:
    """Return the id of a place."""
    assert isinstance(place, pn.Place)
    return str(place.id)
