"""Which question a stored property asks: a formula about the net, or a bound on a latency."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.requirements.latency_bounds import latency_bound
from dineros.analysis.requirements.stored import Asked, asked
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym

if TYPE_CHECKING:
    from dineros.analysis.requirements.latencies import AskedLatency
    from dineros.transformations.rules.phases import OverflowVariant


def question_of(
    property: sym.Property,
    subject: Subject | None = None,
    overflow: OverflowVariant = "weighted",
    is_timed: bool = False,
) -> Asked | AskedLatency:
    """Read a property and what it may assume; see `asked`.

    Raises
    ------
    FormulaError
        It cannot be read.
    """
    bound = latency_bound(property)
    if bound is None:
        return asked(property, subject, overflow, is_timed)
    from dineros.analysis.requirements.latencies import AskedLatency

    if subject is None:
        model = property.eContainer()
        assert isinstance(model, sym.SystemModel)
        subject = (timed_base_subject if is_timed else base_subject)(model, overflow)
    return AskedLatency(property, bound, subject)
