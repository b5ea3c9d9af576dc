"""Small models, each of them valid but for one constraint."""

from tests.support.broken import (
    bounds,
    clauses,
    guards,
    names,
    nets,
    node_nets,
    sizes,
    times,
    token_types,
    tokens,
)
from tests.support.broken.cases import Case
from tests.support.broken.communication import (
    actions,
    callbacks,
    histories,
    ports,
    requests,
    results,
    services,
    topics,
)

FAMILIES = (
    bounds,
    names,
    nets,
    node_nets,
    callbacks,
    topics,
    histories,
    services,
    requests,
    actions,
    ports,
    clauses,
    guards,
    tokens,
    token_types,
    results,
    sizes,
    times,
)
CASES: list[Case] = [case for family in FAMILIES for case in family.CASES]
