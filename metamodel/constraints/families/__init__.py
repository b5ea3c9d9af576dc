"""The constraints, one module for each family; what is a constraint in a module of a family holds."""

from __future__ import annotations

from types import ModuleType

from dineros.metamodel.constraints.constraint import Constraint
from dineros.metamodel.constraints.families import (
    bounds,
    callbacks,
    clauses,
    histories,
    names,
    nets,
    node_nets,
    ports,
    requests,
    results,
    services,
    sizes,
    topics,
)
from dineros.metamodel.constraints.families.actions import clients, servers
from dineros.metamodel.constraints.families.data import guards, token_types, tokens
from dineros.metamodel.constraints.families.times import given


def _of(*families: ModuleType) -> tuple[Constraint, ...]:
    return tuple(
        part for family in families for part in vars(family).values() if isinstance(part, Constraint)
    )


BOUNDS = _of(bounds)
"""Elements that lack a mandatory feature: no other constraint is checked for them."""

OTHERS = _of(
    *(names, nets, node_nets, callbacks, topics, histories, services, requests, servers, clients),
    *(ports, clauses, guards),
    *(tokens, token_types, results, sizes),
    given,
)
