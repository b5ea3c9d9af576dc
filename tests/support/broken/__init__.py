"""Small models, each of them valid but for one constraint."""

from tests.support.broken import (
    bounds,
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
    tokens,
    topics,
)
from tests.support.broken.cases import Case

FAMILIES = (
    bounds,
    names,
    nets,
    node_nets,
    topics,
    histories,
    services,
    requests,
    ports,
    clauses,
    tokens,
    results,
    sizes,
)
CASES: list[Case] = [case for family in FAMILIES for case in family.CASES]
