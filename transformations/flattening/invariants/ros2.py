"""The place invariants that only the rules of ROS 2 guarantee."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.groups import members_of, works_on_goals
from dineros.metamodel.elements import label
from dineros.transformations.flattening.invariants.common import Sum, either, id_of
from dineros.transformations.language.engine import Engine
from dineros.transformations.rules import (
    coming_and_going,
    executors,
    histories,
    lifecycle,
    requests,
    services,
    timers,
)
from dineros.transformations.rules.actions import goals
from dineros.transformations.rules.clients import answers, living
from dineros.transformations.rules.clients import goals as many_goals


def of_requests(engine: Engine) -> Iterator[Sum]:
    """Requests in a history belong to its clients, or to no client if theirs have given up."""
    for application in engine.applications_of(requests.R5):
        (service,) = application.sources
        load = application.made["load"]
        assert isinstance(load, pn.Place)
        held = [each.made["requests"] for each in engine.applications_of(services.S1, [service])]
        for live in engine.applications_of(living.R6Live, [service]):
            terms = [(live.made["live"], 1), *((place, -1) for place in held)]
            yield Sum(f"{id_of(live.made['live'])} counts requests", 0, terms)
        held += [each.made["late"] for each in engine.applications_of(requests.R6, [service])]
        terms = [(load, 1), *((place, -1) for place in held)]
        yield Sum(f"{load.id} counts requests", 0, terms)


def of_goal_histories(engine: Engine) -> Iterator[Sum]:
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
            yield Sum(f"{id_of(load)} counts", 0, [(load, 1), *((place, -1) for place in held)])


def of_timers(engine: Engine) -> Iterator[Sum]:
    """A timer is idle or due."""
    return either(engine, timers.C1, "idle", "due")


def of_executors(engine: Engine) -> Iterator[Sum]:
    """A thread is free or runs a callback."""
    for application in engine.applications_of(executors.E1):
        threads = application.made["threads"]
        running = [each.made["running"] for each in engine.applications_of(executors.E3, application.sources)]
        assert isinstance(threads, pn.Place)
        terms = [(place, 1) for place in (threads, *running)]
        yield Sum(f"{threads.id} or callbacks that run", threads.tokens, terms)


def of_groups(engine: Engine) -> Iterator[Sum]:
    """A callback group is free, or one of its callbacks has begun."""
    for application, group in engine.groups(executors.Lock):
        lock = group["lock"]
        assert isinstance(lock, pn.Place)
        terms: list[tuple[EObject, int]] = [(lock, 1)]
        for member in members_of(application.sources[0]):
            if isinstance(member, sym.CallbackPage) and works_on_goals(member):
                continue
            for rule, role in ((executors.E3, "running"), (executors.E7, "awaiting")):
                terms.extend((each.made[role], 1) for each in engine.applications_of(rule, [member]))
        yield Sum(f"{lock.id} or a callback that has begun", 1, terms)


def of_managed(engine: Engine) -> Iterator[Sum]:
    """A managed node is in one state, and is configured in two of them."""
    for application in engine.applications_of(lifecycle.L1):
        node, place = label(application.sources[0]), application.made
        states = [place[role] for role in ("unconfigured", "inactive", "active", "finalized")]
        yield Sum(f"{node} is in one state", 1, [(state, 1) for state in states])
        configured = place["configured"]
        yield Sum(f"{node} is configured or not", 1, [(configured, 1), (place["away"], 1)])
        terms = [(states[1], 1), (states[2], 1), (configured, -1)]
        yield Sum(f"{node} is configured while inactive or active", 0, terms)
    for application in engine.applications_of(lifecycle.L1Shutdown):
        (own,) = engine.applications_of(lifecycle.L1, application.sources[:1])
        terms = [(application.made["existing"], 1), (own.made["finalized"], 1)]
        yield Sum(f"{label(application.sources[0])} exists or is finalized", 1, terms)


def of_kept(engine: Engine) -> Iterator[Sum]:
    """A message that a writer keeps for a restarting reader is delivered or not yet delivered."""
    for application in engine.applications_of(coming_and_going.L5):
        place, limit = application.made, application.sources[1].limit
        for one, other in (("delivered", "undelivered"), ("kept", "room")):
            terms = [(place[one], 1), (place[other], 1)]
            yield Sum(f"{id_of(place[one])} + {id_of(place[other])}", limit, terms)
        (written,) = engine.applications_of(histories.R2, application.sources[1:3])
        terms = [(place["kept"], 1), (place["delivered"], -1), (written.made["queue.load"], -1)]
        yield Sum(f"{id_of(place['kept'])} is delivered or to be", 0, terms)
