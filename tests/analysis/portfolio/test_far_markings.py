"""What is never possible again from some marking far away is seen from the end of a walk."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.methods.markings import FarMarkings
from dineros.analysis.portfolio.satisfies import Satisfies
from dineros.analysis.portfolio.scheduler import Turn, answered
from tests.analysis import classic_nets as classic

LIMITS = Budget(1 << 28, seconds=60)


def test_a_walk_leads_to_where_it_is_never_possible_again() -> None:
    net = classic.philosophers(14)
    question = Satisfies(net, parse("AG EF eat0 >= 1", "ctl"), NetNames(net))
    answer = answered(question, [Turn(FarMarkings())], LIMITS)
    assert (answer.status, answer.by) == ("violated", "walks")
    assert answer.trace is not None
    end = replay(net, answer.trace)[-1]
    assert not any(net.is_enabled(t, end) for t in range(len(net.transitions)))
    assert len(answer.trace) <= 14


def test_what_holds_or_is_open_there_is_no_answer() -> None:
    net = classic.kanban(3)
    for text in ("AG EF deadlock", "AG EF machine1 >= 3", "EF AG !deadlock", "AF deadlock"):
        question = Satisfies(net, parse(text, "ctl"), NetNames(net))
        found = answered(question, [Turn(FarMarkings())], Budget(1 << 26, seconds=10))
        assert found.status == "unknown", text
