"""State classes counted by TINA: a time Petri net goes out with its intervals, and a digest comes back."""

from __future__ import annotations

import re
import time
from subprocess import CompletedProcess

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.memory import peak_memory
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.state_space import TimedStateSpace
from dineros.analysis.tina.digest import check_size
from dineros.analysis.tina.programs import TinaAnswerError, TinaBudgetError, workplace
from dineros.analysis.tina.timed_models import to_timed_model

#: Rows of the digest, such as ``#      classes     12    11    12     0    12``.
_ROW = re.compile(
    r"^#\s*(classes|states|transitions)\s+(\d+)\s+\S+\s+\S+\s+(\S+)\s+\S+\s*#?\s*$", re.MULTILINE
)
_BOUNDED = re.compile(r"^#\s*bounded\b", re.MULTILINE)


def count_classes(net: TimedNet, kind: Kind, budget: Budget = UNLIMITED) -> TimedStateSpace:
    """Let TINA build the state classes of a net.

    Intervals go out as whole numbers: bounds are divided by the greatest length of which all are multiples.

    Parameters
    ----------
    kind : str
        The construction, by TINA's letter: ``tina -W``, ``-M``, ``-S``, ``-E``, ``-A``.
    budget : Budget, optional
        How long it may take, and how much memory.

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
    counts: tuple[int | None, int | None, int | None] = (None, None, None)
    reason = ""
    try:
        with workplace(to_timed_model(net, "net"), budget) as place:
            counts, is_bounded = _read(net, place.run("tina", f"-{kind}", "-q", "net.net"))
        if not is_bounded:
            counts, reason = (None, None, None), "tina does not find the net bounded"
    except TinaBudgetError as limit:
        reason = limit.why
    return TimedStateSpace(
        construction=kind,
        places=len(net.untimed.places),
        transitions=len(net.untimed.transitions),
        classes=counts[0],
        edges=counts[1],
        markings=None,
        deadlocks=counts[2],
        unit=str(net.unit),
        engine="tina",
        complete=not reason,
        reason=reason,
        seconds=time.perf_counter() - (budget.started or time.perf_counter()),
        peak_memory_bytes=peak_memory(),
    )


def _read(
    net: TimedNet, printed: CompletedProcess[str]
) -> tuple[tuple[int | None, int | None, int | None], bool]:
    """Return classes, edges and deadlocks off a digest, and whether TINA found the net bounded."""
    text = check_size(net.untimed, printed)
    rows = {kind: (int(number), dead) for kind, number, dead in _ROW.findall(text)}
    classes = rows.get("classes") or rows.get("states")
    if classes is None or "transitions" not in rows:
        raise TinaAnswerError("the output of tina has no digest with classes and transitions")
    dead = int(classes[1]) if classes[1].isdigit() else None
    return (classes[0], rows["transitions"][0], dead), _BOUNDED.search(text) is not None
