"""Consequences fold under their causes.

A fault is a consequence of another one if it disappears where that one is mended: the questions are asked
once more of the mended model. It stays a finding of its own where it is found again, where a question is left
open there, and where no change is known that mends the cause. A message that is lost is found again where the
run that loses it can be replayed. What disappears only where all causes are mended together is listed under
the first of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import QUESTIONS, check
from dineros.analysis.checks.overflow import Overflow, Presence
from dineros.analysis.checks.question import Question
from dineros.analysis.consequences.mending import Mend, is_cause, is_proved, mend_of
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.witness import WitnessError, replay
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.transformations.language.copying import deep_copy

SHARE = 0.6
"""Part of the time that is left for asking again."""

LEAST_SECONDS, TIMES = 10.0, 4.0
"""Without a limit of time, asking again may take so long, or so many times what the check took."""

_LOSSES = frozenset(fault.rule for question in (Overflow, Presence) for fault in question.faults)
"""Faults whose run ends with the step that loses a message."""

_Key = tuple[str, tuple[str, ...]]


_Again = Callable[[sym.SystemModel, Collection[_Key], list[Finding], Budget], list[Finding]]
"""Asks a mended model again: which of some faults are not there. None, if one of the given causes is."""


def fold_consequences(
    model: pn.Net,
    report: Report,
    budget: Budget,
    orders: OrderCache | None = None,
    again: _Again | None = None,
) -> None:
    """Put each fault of a report that holds only because of another one into that one, in place.

    Causes come first then, with their consequences.

    Parameters
    ----------
    model : pn.Net
        The model that the report is about; it is not changed.
    report : Report
        A complete report.
    budget : Budget
        That of the check, with what is left of it.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    again : callable, optional
        Asks a mended model again; by default without times.
    """
    # Time may run out: errors first, as they explain more.
    causes = sorted(filter(is_cause, report.findings), key=lambda finding: finding.severity != "error")
    if not isinstance(model, sym.SystemModel) or not causes or not _may_follow(report):
        return
    _Folding(model, report, _limited(budget), again or partial(_without, orders)).fold(causes)


def _may_follow(report: Report) -> list[Finding]:
    return [each for each in report.findings if each.severity != "note" and not is_cause(each)]


def _limited(budget: Budget) -> Budget:
    if budget.left is not None:
        return budget.share(SHARE)
    return replace(budget, started=None, seconds=max(LEAST_SECONDS, TIMES * budget.spent)).begun()


class _Folding:
    def __init__(self, model: sym.SystemModel, report: Report, budget: Budget, again: _Again) -> None:
        self._model = model
        self._report = report
        self._budget = budget
        self._again = again
        self._left = _may_follow(report)

    def fold(self, causes: Sequence[Finding]) -> None:
        """Ask again where each of the causes is mended, and where all of them are."""
        found: dict[int, list[Finding]] = {id(cause): [] for cause in causes}
        mends: list[Mend] = []
        try:
            for number, cause in enumerate(causes):
                self._budget.stage(f"consequences of {cause.rule}, {number + 1} of {len(causes)}")
                mend = mend_of(self._model, cause, self._budget)
                if mend is not None:
                    mends.append(mend)
                    found[id(cause)] += self._gone([mend], {key_of(cause)})
            if len(mends) > 1 and self._left:
                self._budget.stage("consequences of all causes together")
                found[id(causes[0])] += self._gone(mends, ())
        except BudgetExceededError:
            pass
        folded = {id(each) for some in found.values() for each in some}
        first, others = [], []
        for finding in self._report.findings:
            consequences = found.get(id(finding), ())
            if consequences:
                first.append(replace(finding, consequences=tuple(consequences)))
            elif id(finding) not in folded:
                others.append(finding)
        self._report.findings[:] = [*first, *others]

    def _gone(self, mends: Sequence[Mend], causes: Collection[_Key]) -> list[Finding]:
        """Return what disappears where causes are mended, and do so, too; take it out of what is left."""
        if not self._left:
            return []
        mended, _ = deep_copy(self._model)
        assert isinstance(mended, sym.SystemModel)
        for mend in mends:
            mend(mended)
        if any(problem.severity == "error" for problem in validate(mended)):
            return []
        subject = base_subject(mended)
        open_now = [each for each in self._left if not _is_lost_again(each, subject)]
        if not open_now:
            return []
        gone = self._again(mended, causes, open_now, self._budget)
        self._left = [each for each in self._left if each not in gone]
        return gone


def _without(
    orders: OrderCache | None,
    mended: sym.SystemModel,
    causes: Collection[_Key],
    some: list[Finding],
    budget: Budget,
) -> list[Finding]:
    """Ask a model again without its times."""
    rules = {rule for rule, _ in causes if not is_proved(rule)} | {finding.rule for finding in some}
    again = check(mended, budget, orders=orders, questions=_asking(rules), is_shown=False)
    still = {key_of(finding) for finding in again.findings if finding.severity != "note"}
    if not still.isdisjoint(causes) or not again.open_rules.isdisjoint(rule for rule, _ in causes):
        return []
    return [each for each in some if key_of(each) not in still and each.rule not in again.open_rules]


def _is_lost_again(finding: Finding, subject: Subject) -> bool:
    """Tell whether a run that loses a message does so in the net of a mended model, too."""
    if finding.rule not in _LOSSES or finding.witness is None or not finding.witness.steps:
        return False
    names = [step.transition for step in finding.witness.steps]
    if not subject.transition_index.keys() >= set(names):
        return False
    try:
        replay(subject.net, [subject.transition_index[name] for name in names])
    except WitnessError:
        return False
    return True


def _asking(rules: Collection[str]) -> list[Question]:
    """Return the questions that find faults of some rules, and what they rest on."""
    return [
        each
        for each in QUESTIONS
        if isinstance(each, Boundedness) or any(fault.rule in rules for fault in each.faults)
    ]


def key_of(finding: Finding) -> _Key:
    """Return what tells a fault from others of a model."""
    return finding.rule, finding.elements
