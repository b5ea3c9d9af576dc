"""Which parts that a check found never used are used by some run of a corrected or timed model."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.plans import Plans
from dineros.analysis.checks.unused import FAULTS, unused_parts
from dineros.analysis.model.subject import Subject
from dineros.analysis.walks.first_round import first_round
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import pn
from dineros.metamodel.elements import node_net_of

_RULES = frozenset(fault.rule for fault in FAULTS)


def used_in_runs(subject: Subject, some: Sequence[Finding], budget: Budget) -> list[Finding]:
    """Return which of some faults, that parts are never used, short walks disprove."""
    asked = _asked(subject, some)
    return disproved(subject, first_round(subject.net, budget, asked).ways, some) if asked else []


def used_in_plans(subject: Subject, some: Sequence[Finding]) -> list[Finding]:
    """Return which of some faults, that parts are never used, planned runs disprove."""
    plans = Plans(subject.net)
    ways = [plans.way_to(transition) for transition in _asked(subject, some)]
    return disproved(subject, {fired for way in ways for fired in way or ()}, some)


def is_unused_part(finding: Finding) -> bool:
    """Return whether a fault is that a part is never used."""
    return finding.rule in _RULES


def disproved(subject: Subject, fired: Collection[int], some: Sequence[Finding]) -> list[Finding]:
    """Return which faults of unused parts are wrong, because some transitions can fire.

    A transition that did not fire in them may still fire. So a fault is disproved only if nothing at all
    would be found of its element: a service that no run called is not one that returns.

    Parameters
    ----------
    fired : collection of int
        Transitions that were met in runs.
    some : sequence of Finding
        The faults; those of other kinds are not in the answer.
    """
    never = set(range(len(subject.net.transitions))).difference(fired)
    open_still = {each.elements for each in unused_parts(subject, never)}
    return [each for each in some if each.rule in _RULES and each.elements not in open_still]


def _asked(subject: Subject, some: Sequence[Finding]) -> list[int]:
    return _transitions_of(subject, {id for each in some if each.rule in _RULES for id in each.elements})


def _transitions_of(subject: Subject, elements: Collection[str]) -> list[int]:
    """Return the transitions of a net that were made of some elements of the model, or of parts of them."""
    found = set()
    for link in subject.links():
        if isinstance(link.target, pn.Transition):
            owners = [node_net_of(source) for source in link.sources]
            ids = {getattr(each, "id", None) for each in (*link.sources, *owners)}
            if not ids.isdisjoint(elements):
                found.add(subject.transition_index[link.target.id])
    return sorted(found)
