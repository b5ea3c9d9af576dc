"""State classes counted by TINA: a time Petri net goes out with its intervals, and a digest comes back."""

from __future__ import annotations

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.state_space import TimedStateSpace, figures
from dineros.analysis.tina.digest import read_counts
from dineros.analysis.tina.programs import TinaBudgetError, workplace
from dineros.analysis.tina.timed_models import to_timed_model


def count_classes(net: TimedNet, kind: Kind, budget: Budget = UNLIMITED) -> TimedStateSpace:
    """Let TINA build the state classes of a net.

    Intervals go out as whole numbers: bounds are divided by the greatest length of which all are multiples.

    Parameters
    ----------
    kind : str
        The construction, by TINA's letter: ``tina -W``, ``-M``, ``-S``, ``-E``, ``-A``.

    Returns
    -------
    TimedStateSpace
        With classes and edges; TINA counts no markings.

    Raises
    ------
    TinaError
        TINA is not there, failed, or read another net than was written.
    """
    budget = budget.begun()
    counts: tuple[int | None, int | None, int | None, int | None] = (None, None, None, None)
    reason = None
    try:
        with workplace(to_timed_model(net, "net"), budget) as place:
            found = read_counts(net.untimed, place.run("tina", f"-{kind}", "-q", "net.net"))
        if found.is_bounded:
            counts = found.states, found.arcs, None, found.deadlocks
        else:
            reason = "tina does not find the net bounded"
    except TinaBudgetError as limit:
        reason = limit.why
    return figures(net, kind, counts, "tina", reason, budget)
