"""Parts that are used once a cause is fixed, shown by planned runs and short walks, without a search.

Only changes are tried that are known at once. For callbacks that wait for each other, these are single
changes of groups and threads after which neither the run of the finding nor a planned one closes the circle.
A run of the changed model that uses a part shows that it is not used because of the cause.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.searching import near_circles
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.consequences.cause_fixes import fix_of, is_proved
from dineros.analysis.consequences.circle_fixes import circle_after, circle_of
from dineros.analysis.consequences.gone import is_in
from dineros.analysis.consequences.used import is_unused_part, used_in_plans, used_in_runs
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.suggestions.changes import Changes, against_circle
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.transformations.language.copying import deep_copy

WALKS, WALK_SECONDS = Share(time=0.8), 5.0
"""Share of walks; seconds after each change, for their first turn only."""


def folded_quickly(
    model: sym.SystemModel, causes: Sequence[Finding], some: Sequence[Finding], budget: Budget
) -> Iterator[tuple[Finding, list[Finding]]]:
    """Yield causes, each with the parts that planned runs use once it is fixed.

    Parameters
    ----------
    model : sym.SystemModel
        The model; it is not changed.
    causes : sequence of Finding
        What may be a cause.
    some : sequence of Finding
        What may follow; only parts that are never used are looked at, each for its first cause.
    budget : Budget
        Time; what is found until it runs out is yielded.
    """
    left = [each for each in some if is_unused_part(each)]
    fixed = list[tuple[Finding, Subject]]()
    for cause in sorted(causes, key=lambda each: each.rule == Callbacks.CIRCLE.rule):  # one change each first
        for subject in _fixed(model, cause, budget) if left and is_proved(cause.rule) else ():
            used = used_in_plans(subject, left)
            left = [each for each in left if not is_in(each, used)]
            if used:
                yield cause, used
            fixed.append((cause, subject))
            if budget.is_over:
                return
    walking = WALKS.share(budget)
    for cause, subject in fixed:
        if not left or walking.is_over:
            return
        used = used_in_runs(subject, left, walking.at_most(WALK_SECONDS))
        left = [each for each in left if not is_in(each, used)]
        if used:
            yield cause, used


def _fixed(model: sym.SystemModel, cause: Finding, budget: Budget) -> Iterator[Subject]:
    """Yield the nets of models in which a cause is fixed, one for each change that is known at once."""
    if cause.rule != Callbacks.CIRCLE.rule:
        fix = fix_of(model, cause, UNLIMITED)
        if fix is not None:
            copied, _ = deep_copy(model)
            assert isinstance(copied, sym.SystemModel)
            fix(copied)
            if _is_valid(copied):
                yield base_subject(copied)
        return
    circle = circle_of(cause)
    for changes in () if circle is None else against_circle(Changes(), circle):
        if budget.is_over:
            return
        changed = changes.applied(model)
        if _is_valid(changed):
            subject = base_subject(changed)
            planned = near_circles(subject.net, Waiting(subject), UNLIMITED)
            still = [each.circle for each in planned] + [circle_after(cause, subject)]
            if all(each is None or each.elements != cause.elements for each in still):
                yield subject


def _is_valid(model: sym.SystemModel) -> bool:
    return all(problem.severity != "error" for problem in validate(model))
