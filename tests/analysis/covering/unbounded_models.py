"""``python -m tests.analysis.covering.unbounded_models 40``: checks of models against plain searches.

A test does the same with a few. Each line says what a check took; an error ends it.
"""

from __future__ import annotations

import sys
import time

from dineros.analysis.checks.check import check
from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import base_subject
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import sym
from tests.analysis.covering.plain import can_fire_by_karp_miller, plain_search
from tests.support.systems.unbounded_systems import each_of

MOST = 100_000


def compare(model: sym.SystemModel, report: Report, most: int) -> None:
    """Raise if a check leaves unknown, or denies, what is found or proved by plain searches."""
    subject = base_subject(model)
    seen, can_fire = plain_search(subject.net, most), can_fire_by_karp_miller(subject.net)
    rules = {(finding.rule, finding.elements) for finding in report.findings}
    for queue in queues(subject):
        drops = {subject.transition_index[drop] for drop in queue.drops}
        overflows = ("queue-overflow", queue.elements) in rules
        if drops & seen.enabled:
            assert overflows, f"{queue} overflows"
        elif can_fire is not None and drops.isdisjoint(can_fire):
            assert f"{queue} never overflows" in report.proved, f"{queue} never overflows"
    open_questions = [unknown.question for unknown in report.unknown]
    still_open = [question for question in open_questions if question.startswith("whether these can ever")]
    for t in seen.enabled:
        assert not any(subject.transition_text(t) in question for question in still_open)
        assert ("dead-transition", (subject.transition_element(t),)) not in rules
    if can_fire is not None:
        dead = [t for t in range(len(subject.net.transitions)) if t not in can_fire]
        assert not any(subject.transition_text(t) in question for t in dead for question in still_open)
    if seen.has_deadlock:
        assert any(rule == "deadlock" for rule, _ in rules), "a deadlock was overlooked"
    assert "no deadlock" not in report.proved or not seen.has_deadlock
    if can_fire is not None:
        assert "whether the net is bounded" not in open_questions


def examine(model: sym.SystemModel) -> str:
    """Check a model, compare, and say what was found."""
    began = time.perf_counter()
    report = check(model)
    took = time.perf_counter() - began
    compare(model, report, MOST)
    found = ", ".join(sorted({finding.rule for finding in report.findings}))
    unknown = "; ".join(str(unknown) for unknown in report.unknown if unknown.may_be_fault)
    return f"{took:.1f} s, {found}; unknown: {unknown or 'nothing'}"


if __name__ == "__main__":
    each_of(int(sys.argv[1]) if len(sys.argv) > 1 else 40, examine)
