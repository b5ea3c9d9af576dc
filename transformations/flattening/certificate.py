"""The place invariants that the rules guarantee; they are added to each flattened net and checked on it.

An invariant is a weighted sum of tokens that no firing changes. The check needs only the incidence
matrix and the initial marking, so it is independent of the rules (Murata, Proc. IEEE 77(4), 1989, Sect. V).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import TypeAlias

from dineros.metamodel import pn, pnm
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import DinerosError
from dineros.transformations.flattening.invariants import common
from dineros.transformations.flattening.invariants.common import Sum
from dineros.transformations.language.engine import Engine
from dineros.transformations.rules.phases import MiddlewareVariant

Kind: TypeAlias = Callable[[Engine], Iterable[Sum]]


class CertificateError(DinerosError):
    """A flattened net lacks a place invariant that its rules guarantee: a fault in a rule."""


def add_certificate(
    net: pnm.PetriNetModel,
    engine: Engine,
    made: Mapping[EObject, EObject],
    middleware: MiddlewareVariant,
    times: bool,
) -> list[pnm.PlaceInvariant]:
    """Add the invariants of the elements that the rules made to a net; return the invariants."""
    certificate = [_invariant(each, made) for kind in _kinds(middleware, times) for each in kind(engine)]
    net.certificate.extend(certificate)
    return certificate


def _kinds(middleware: MiddlewareVariant, times: bool) -> Iterator[Kind]:
    """Yield the kinds of invariants of a variant; modules of rules that it does not run are not imported."""
    of_clients: Kind = common.of_clients
    if times:
        from dineros.transformations.flattening.invariants import timed

        of_clients = partial(common.of_clients, with_times=timed.calls_under_way)
        yield from (timed.of_clocks, timed.of_orders, timed.of_time_outs)
    yield from (common.of_queues, common.of_bounds, common.of_instances, of_clients)
    yield from (common.of_slots, common.of_goals, common.of_signals, common.of_disjunctions)
    if middleware == "ros2":
        from dineros.transformations.flattening.invariants import ros2

        yield from (ros2.of_requests, ros2.of_goal_histories, ros2.of_timers, ros2.of_executors)
        yield from (ros2.of_groups, ros2.of_managed, ros2.of_kept)


def _invariant(guaranteed: Sum, made: Mapping[EObject, EObject]) -> pnm.PlaceInvariant:
    summands = []
    for place, weight in guaranteed.terms:
        image = made[place]
        assert isinstance(image, pn.Place)
        summands.append(pnm.InvariantTerm(place=image, weight=weight))
    return pnm.PlaceInvariant(name=guaranteed.name, value=guaranteed.value, terms=summands)


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
