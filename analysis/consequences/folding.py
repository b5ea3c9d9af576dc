"""Consequences fold under their causes.

A fault is a consequence of another one if it disappears in a model in which that one is repaired: the
questions are asked again for that model. It stays a finding of its own if it is found again, if a
question stays open there, or if no change is known that fixes the cause. A message that is lost is
found again where the run that loses it can be replayed. That a part is never used is disproved by a run of
the corrected model which uses it; only what no run settles needs all its markings. A fault that disappears
only if several causes are repaired together is listed under the first of them, and names the others. A
callback that never ends is a cause, and may be a consequence of another one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.checks.check import QUESTIONS, check
from dineros.analysis.checks.overflow import Overflow, Presence
from dineros.analysis.checks.question import finding_rules
from dineros.analysis.consequences.cause_fixes import fix_of, is_cause, is_effect, is_proved
from dineros.analysis.consequences.circle_fixes import Fix, let_calls_end
from dineros.analysis.consequences.gone import Key, faults_of, gone_from, is_in, key_of
from dineros.analysis.consequences.quick import folded_quickly
from dineros.analysis.consequences.together import fewest_causes
from dineros.analysis.consequences.used import used_in_runs
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import DinerosError
from dineros.transformations.language.copying import deep_copy

AGAIN = Share(time=0.9)
"""Share of asking again."""

FIX = Share(time=0.6)
"""The share of it for the search for a change that removes a cause."""

HIDDEN = Share(time=0.6)
"""Share of the remaining budget for circles that are found only if others are repaired."""

TOGETHER = Share(time=0.5)
"""Share of the remaining budget for the search for few causes that must be repaired together."""

QUICK = "consequences that planned runs show"
"""The stage of what needs no search; it begins again after each cause, so that answers are shown."""

LEAST_SECONDS, TIMES = 30.0, 4.0
"""Without a limit of time, asking again may take so long, or so many times what the check took."""

_LOSSES = frozenset(fault.rule for question in (Overflow, Presence) for fault in question.faults)
"""Faults whose run ends with the step that loses a message."""

_Fixed = tuple[Finding, Fix]
"""A cause, with what fixes it."""

_Again = Callable[[sym.SystemModel, Collection[Key], list[Finding], Budget], list[Finding]]
"""Asks a corrected model again: which of some faults are not there. None, if one of the given causes is."""


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
        Asks a corrected model again; by default without times.
    """
    # Time may run out: errors first, as they explain more; what may itself be a consequence comes last.
    causes = sorted(
        (each for each in report.findings if each.severity != "note" and is_cause(model, each)),
        key=lambda finding: (is_effect(finding), finding.severity != "error"),
    )
    if not isinstance(model, sym.SystemModel) or not causes:
        return
    _Folding(model, report, _limited(budget), again or partial(_without, orders), again is not None).fold(
        causes
    )


def _may_follow(model: pn.Net, report: Report) -> list[Finding]:
    return [
        each
        for each in report.findings
        if each.severity != "note" and (is_effect(each) or not is_cause(model, each))
    ]


def _limited(budget: Budget) -> Budget:
    if budget.left is not None:
        return AGAIN.share(budget)
    return replace(budget, started=None, seconds=max(LEAST_SECONDS, TIMES * budget.spent)).begun()


class _Folding:
    def __init__(
        self, model: sym.SystemModel, report: Report, budget: Budget, again: _Again, is_timed: bool
    ) -> None:
        self._model = model
        self._report = report
        self._budget = budget
        self._again = again
        self._is_timed = is_timed
        self._left = _may_follow(model, report)
        self._all = list(report.findings)
        self._others: dict[int, tuple[Finding, ...]] = {}  # of a consequence, by its identity

    def fold(self, causes: Sequence[Finding]) -> None:
        """Ask again where each of the causes is fixed, and where all of them are."""
        found: dict[int, list[Finding]] = {id(cause): [] for cause in causes}
        fixed: list[_Fixed] = []
        if not self._is_timed:
            self._fold_quickly(causes, found)
        # A cause has a share of the time, and a second one of the time that the others leave if the first was
        # not enough.
        open_causes = self._round(causes, found, fixed)
        if open_causes and not self._budget.is_over:
            self._round(open_causes, found, fixed)
            ranks = {id(cause): rank for rank, cause in enumerate(causes)}
            fixed.sort(key=lambda each: ranks[id(each[0])])
        if fixed:
            folded = {id(each) for some in found.values() for each in some}
            self._fold_together([each for each in fixed if id(each[0]) not in folded], fixed, found)
        self._put(found)

    def _put(self, found: dict[int, list[Finding]]) -> None:
        """Put what is known by now into the report, which may be printed at any time."""
        folded = {id(each) for some in found.values() for each in some}
        order = {id(each): number for number, each in enumerate(self._all)}
        first, others = [], []
        for finding in self._all:
            consequences = sorted(found.get(id(finding), ()), key=lambda each: order[id(each)])
            if consequences:
                named = [self._with_others(each) for each in consequences]
                first.append(replace(finding, consequences=tuple(named)))
            elif id(finding) not in folded:
                others.append(finding)
        self._report.findings[:] = [*first, *others]

    def _fold_quickly(self, causes: Sequence[Finding], found: dict[int, list[Finding]]) -> None:
        """List unused parts under causes, where changes and runs that need no search show them."""
        self._budget.stage(QUICK)
        for cause, gone in folded_quickly(self._model, causes, self._left, self._budget):
            found[id(cause)] += gone
            self._left = [each for each in self._left if not is_in(each, gone)]
            self._put(found)
            self._budget.stage(QUICK)

    def _with_others(self, consequence: Finding) -> Finding:
        return replace(consequence, together=self._others.get(id(consequence), ()))

    def _fold_together(
        self, owners: Sequence[_Fixed], fixed: Sequence[_Fixed], found: dict[int, list[Finding]]
    ) -> None:
        """Ask again where several causes are fixed together; list what disappears under the first of them.

        Parameters
        ----------
        owners : sequence of (Finding, Fix)
            Causes that are not consequences themselves.
        fixed : sequence of (Finding, Fix)
            All causes with a change that fixes them.
        found : dict
            The consequences of each cause, by its identity, which is added to.
        """
        self._budget.stage("consequences of all causes together")
        every = list(fixed)
        gone: list[Finding] = []
        with suppress(BudgetExceededError):
            if len(fixed) > 1:
                gone += self._gone(every, self._budget)
            every += self._hidden(fixed)
            if len(every) > len(fixed):
                gone += self._gone(every, self._budget)
        if not gone:
            return
        budget = TOGETHER.share(self._budget)

        def gone_again(fewer: Sequence[_Fixed], some: Sequence[Finding]) -> list[Finding]:
            # A change found in the repaired model may depend on the repair.
            with suppress(BudgetExceededError, DinerosError):
                return self._asked(fewer, some, budget)
            return []

        for causes, consequences in fewest_causes(every, gone, gone_again):
            names = [cause for cause, _ in causes]
            first = next((cause for cause, _ in owners if is_in(cause, names)), None)
            if first is not None:
                found[id(first)] += consequences
                others = tuple(cause for cause in names if cause is not first)
                self._others.update((id(each), others) for each in consequences)

    def _hidden(self, fixed: Sequence[_Fixed]) -> list[_Fixed]:
        """Return circles of callbacks that are found only if causes are fixed, with what fixes them."""
        causes = [cause for cause, _ in fixed]
        left = [each for each in self._left if not is_in(each, causes) and each.rule not in _LOSSES]
        if not left or self._is_timed or all(cause.rule != Callbacks.CIRCLE.rule for cause in causes):
            return []
        model = self._with_fixes(fixed)
        budget = HIDDEN.share(self._budget)
        report = check(
            model, budget, questions=finding_rules({Callbacks.CIRCLE.rule}, QUESTIONS), is_shown=False
        )
        known = {key_of(cause) for cause, _ in fixed}
        found = []
        for each in report.findings:
            if each.rule == Callbacks.CIRCLE.rule and key_of(each) not in known:
                fix = let_calls_end(model, each, budget)
                if fix is not None:
                    found.append((replace(each, message=f"found if others are fixed: {each.message}"), fix))
        return found

    def _round(
        self, causes: Sequence[Finding], found: dict[int, list[Finding]], fixed: list[_Fixed]
    ) -> list[Finding]:
        """Ask again where each of some causes is fixed; return those whose time ran out."""
        out_of_time = []
        # The last share is for all of them together.
        shares = fairly(causes, self._budget, kept=int(len(causes) > 1))
        for number, (cause, share) in enumerate(shares, 1):
            if is_effect(cause) and not is_in(cause, self._left):
                continue  # it is a consequence
            if all(each is cause for each in self._left):
                continue
            share.stage(f"consequences of {cause.rule}, {number} of {len(causes)}")
            searching = FIX.share(share)
            try:
                fix = fix_of(self._model, cause, searching)
                if fix is None:
                    searching.check_time()
            except BudgetExceededError:
                out_of_time.append(cause)
                fix = None
            if fix is not None:
                fixed.append((cause, fix))
                with suppress(BudgetExceededError):
                    found[id(cause)] += self._gone([(cause, fix)], share)
                    self._put(found)
            if found[id(cause)]:
                self._left = [each for each in self._left if each is not cause]
        return out_of_time

    def _gone(self, fixed: Sequence[_Fixed], budget: Budget) -> list[Finding]:
        """Take out of the remaining faults those that disappear if causes are repaired; return them."""
        gone = self._asked(fixed, self._left, budget)
        self._left = [each for each in self._left if not is_in(each, gone)]
        return gone

    def _asked(self, fixed: Sequence[_Fixed], findings: Sequence[Finding], budget: Budget) -> list[Finding]:
        """Return which of some findings disappear where causes are fixed."""
        causes = [cause for cause, _ in fixed]
        left = [each for each in findings if not is_in(each, causes)]
        if not left or budget.is_over:
            return []
        model = self._with_fixes(fixed)
        if any(problem.severity == "error" for problem in validate(model)):
            return []
        subject = base_subject(model)
        open_now = [each for each in left if self._is_timed or not _is_lost_again(each, subject)]
        if not open_now:
            return []
        asked = {key_of(cause) for cause in causes} if len(causes) == 1 else set()
        return self._again(model, asked, open_now, budget)

    def _with_fixes(self, fixed: Sequence[_Fixed]) -> sym.SystemModel:
        model, _ = deep_copy(self._model)
        assert isinstance(model, sym.SystemModel)
        for _, fix in fixed:
            fix(model)
        return model


def _without(
    orders: OrderCache | None,
    fixed: sym.SystemModel,
    causes: Collection[Key],
    some: list[Finding],
    budget: Budget,
) -> list[Finding]:
    """Ask a model again without its times."""
    used = used_in_runs(base_subject(fixed), some, budget)
    rest = [each for each in some if not is_in(each, used)]
    rules = {rule for rule, _ in causes if not is_proved(rule)}
    if not rest and not rules:
        return used
    rules |= {finding.rule for finding in rest}
    again = check(fixed, budget, orders=orders, questions=finding_rules(rules, QUESTIONS), is_shown=False)
    still = faults_of(again)
    if any(key in still or key[0] in again.open_rules for key in causes if not is_proved(key[0])):
        return []
    return gone_from(again, some, used)


def _is_lost_again(finding: Finding, subject: Subject) -> bool:
    """Return whether a run that loses a message does so in the net of a corrected model, too."""
    if finding.rule not in _LOSSES or finding.witness is None or not finding.witness.steps:
        return False
    return finding.witness.ends_at(subject) is not None
