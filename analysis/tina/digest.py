"""State spaces counted by TINA: the digest that ``tina -R`` prints, read back."""

from __future__ import annotations

import re
from dataclasses import dataclass
from subprocess import CompletedProcess

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.tina.programs import TinaAnswerError, workplace

#: Rows of the digest, such as ``#      states      12     5     ?     0     12``; timed nets have classes.
_ROW = re.compile(
    r"^#\s*(classes|states|transitions)\s+(\d+)\s+\S+\s+\S+\s+(\S+)\s+\S+\s*#?\s*$", re.MULTILINE
)
#: The size of the net as TINA has read it: ``# net N, 6 places, 6 transitions, 14 arcs``.
_SIZE = re.compile(r"(\d+) places, (\d+) transitions")
#: What TINA found of the net: ``# bounded, not live, reversible``. Anything else promises no bound.
_BOUNDED = re.compile(r"^#\s*bounded\b", re.MULTILINE)


@dataclass(frozen=True)
class TinaCounts:
    """What TINA counted.

    Attributes
    ----------
    deadlocks : int or None
        Markings that enable nothing, if TINA reports them.
    is_bounded : bool
        Whether it found the net bounded; otherwise the counts are those of what it looked at.
    """

    states: int
    arcs: int
    deadlocks: int | None
    is_bounded: bool


def count(net: CompiledNet, budget: Budget = UNLIMITED) -> TinaCounts:
    """Let TINA build the marking graph of a net.

    Raises
    ------
    TinaError
        TINA is not there, failed, took too long, or read another net than was written.
    """
    with workplace(net, budget) as place:
        # -R: the marking graph; -q: nothing but the digest.
        return read_counts(net, place.run("tina", "-R", "-q", "net.net"))


def read_counts(net: CompiledNet, printed: CompletedProcess[str]) -> TinaCounts:
    """Read the counts of a net off what ``tina`` printed.

    Raises
    ------
    TinaError
        There is no digest, or it is that of another net.
    """
    text = printed.stdout + "\n" + printed.stderr
    size = _SIZE.search(text)
    if size and (int(size[1]), int(size[2])) != (len(net.places), len(net.transitions)):
        raise TinaAnswerError(
            f"tina has read {size[1]} places and {size[2]} transitions,"
            f" where the net has {len(net.places)} and {len(net.transitions)}"
        )
    return read_digest(text)


def read_digest(printed: str) -> TinaCounts:
    """Read the counts off a digest of ``tina``; state classes count as states.

    Raises
    ------
    TinaError
        There is no digest.

    Examples
    --------
    >>> read_digest('''# net ring, 2 places, 2 transitions, 4 arcs
    ... # bounded, live, reversible
    ... # abstraction        count      props      psets       dead       live
    ... #      states            3          2          ?          0          3
    ... # transitions            4          2          ?          0          2
    ... ''')
    TinaCounts(states=3, arcs=4, deadlocks=0, is_bounded=True)
    """
    rows = {kind: (int(number), dead) for kind, number, dead in _ROW.findall(printed)}
    states, dead = rows.get("classes") or rows.get("states") or (None, "")
    if states is None or "transitions" not in rows:
        raise TinaAnswerError("the output of tina has no digest with states and transitions")
    return TinaCounts(
        states,
        rows["transitions"][0],
        int(dead) if dead.isdigit() else None,
        _BOUNDED.search(printed) is not None,
    )
