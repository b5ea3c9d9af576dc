"""Small models, each of them valid but for one constraint."""

from tests.support.broken import (
    actions,
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
    token_types,
    tokens,
    topics,
)
from tests.support.broken.cases import Case

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
    tokens,
    token_types,
    results,
    sizes,
)
CASES: list[Case] = [case for family in FAMILIES for case in family.CASES]
