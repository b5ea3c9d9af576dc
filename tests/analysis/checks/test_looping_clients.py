"""Models with exponentially many semiflows are counted and checked all the same."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.explicit import explore
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.semiflows import semiflows
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.metamodel.constraints import validate
from tests.support.systems.looping_clients import COUNTS, looping_clients


@pytest.mark.parametrize(("clients", "services"), COUNTS)
def test_counts(clients: int, services: int) -> None:
    model = looping_clients(clients, services)
    assert validate(model) == []
    net = base_subject(model).net
    space, searched = symbolic_state_space(net), explore(net, Budget(1 << 26), workers=1)
    assert (space.markings, space.arcs()) == COUNTS[clients, services]
    assert (searched.markings, searched.arcs) == COUNTS[clients, services]


def test_check_leaves_nothing_open_where_semiflows_are_too_many() -> None:
    model = looping_clients(3, 3)
    assert semiflows(base_subject(model).net) is None
    report = check(model)
    assert report.unknown == []
    assert "no deadlock" in report.proved
