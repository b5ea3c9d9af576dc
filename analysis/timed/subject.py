"""What is analysed with time: a model compiled to a time Petri net."""

from __future__ import annotations

from dataclasses import dataclass, field

from dineros.analysis.model.subject import Subject
from dineros.analysis.timed.nets import TimedNet, compile_timed_net
from dineros.metamodel import pn, sym
from dineros.transformations.flattening.bounding import bounded
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.catalogue import OverflowVariant, SignalVariant


@dataclass(frozen=True)
class TimedSubject(Subject):
    """A time Petri net under analysis; `net` is the same net without its times."""

    timed: TimedNet = field(kw_only=True)


def timed_subject_of(
    model: pn.Net,
    signals: SignalVariant = "input-enabled",
    overflow: OverflowVariant = "weighted",
) -> TimedSubject:
    """Flatten a system model, and compile it with its times; compile any other net.

    Raises
    ------
    DinerosError
        An interval is empty or negative; see `compile_timed_net`.
    """
    flattened = flatten(model, signals, overflow) if isinstance(model, sym.SystemModel) else None
    timed = compile_timed_net(bounded(model) if flattened is None else flattened.net)
    return TimedSubject(model, timed.untimed, flattened, timed=timed)
