"""Firing sequences of TINA, read back and replayed on our net before anyone sees them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.verdicts.verdict import ReplayError, check_counterexample
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import WitnessError, replay
from dineros.analysis.tina.programs import TinaAnswerError

#: Parts of a .scn file. Times follow a transition after ``@`` or ``$``; they are skipped: our nets have none.
_PART = re.compile(
    r"(?P<comment>^[ \t]*#[^\n]*)|(?P<line>\n)|(?P<blank>[ \t\r]+)"
    r"|\{(?P<braced>(?:[^{}\\]|\\.)*)\}(?=\s|\Z)|(?P<plain>[A-Za-z0-9_']+)(?=\s|\Z)",
    re.DOTALL | re.MULTILINE,
)


def read_sequence(net: CompiledNet, text: str, program: str) -> list[list[int]]:
    r"""Read a firing sequence in the form of ``.scn`` files.

    Parameters
    ----------
    text : str
        Names of transitions, separated by blanks; lines that begin with ``#`` are comments.
    program : str
        Who has written it, for messages.

    Returns
    -------
    list of list of int
        Transitions, line by line.

    Raises
    ------
    TinaError
        It holds something else, or names no transition of the net.

    Examples
    --------
    >>> net = CompiledNet.build({}, [("t",), ("{odd",)])
    >>> read_sequence(net, "# made by hand" + chr(10) + "t {\\{odd}" + chr(10) + "t", "selt")
    [[0, 1], [0]]
    """
    index = {name: number for number, name in enumerate(net.transitions)}
    rows: list[list[int]] = [[]]
    position = 0
    while position < len(text):
        part = _PART.match(text, position)
        if part is None:
            near = " ".join(text[position : position + 40].split())
            raise TinaAnswerError(f"{program} wrote a path that cannot be read: {near!r}")
        position = part.end()
        if part.lastgroup == "line":
            rows.append([])
        elif part.lastgroup in ("braced", "plain"):
            name = (
                re.sub(r"\\(.)", r"\1", part["braced"], flags=re.DOTALL) if part["braced"] else part["plain"]
            )
            if name not in index:
                raise TinaAnswerError(
                    f"{program} wrote a path with {name!r}, which is not a transition of the net"
                )
            rows[-1].append(index[name])
    return [row for row in rows if row]


def to_goal(
    net: CompiledNet, trace: Sequence[int], is_goal: Callable[[list[int]], bool], program: str
) -> tuple[int, ...]:
    """Replay a trace and return what of it leads to the first marking that is a goal.

    Raises
    ------
    TinaError
        The net cannot fire it, or it does not lead there.
    """
    try:
        markings = replay(net, trace)
    except WitnessError as error:
        raise TinaAnswerError(f"the path of {program} is not a firing sequence of the net: {error}") from None
    for length, marking in enumerate(markings):
        if is_goal(marking):
            return tuple(trace[:length])
    raise TinaAnswerError(f"the path of {program} does not reach the goal")


def lasso(
    net: CompiledNet,
    rows: Sequence[Sequence[int]],
    formula: Formula,
    atoms: BoundAtoms,
    weak: Sequence[int] = (),
    strong: Sequence[int] = (),
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return a counterexample as a path and what is fired forever after it.

    The manual does not say where in a ``.scn`` file the part begins that repeats; for TINA's program ``plan``
    it is the last line. So every marking to which the sequence comes back is tried, that line first, then the
    latest; taken is what is a run of the net that violates the formula by the definition of both.

    Raises
    ------
    TinaError
        The net cannot fire the sequence, or it is not a counterexample.
    """
    trace = [transition for row in rows for transition in row]
    try:
        markings = [tuple(marking) for marking in replay(net, trace)]
    except WitnessError as error:
        raise TinaAnswerError(f"the counterexample of selt is not a run of the net: {error}") from None
    last = markings[-1]
    returns = [start for start in range(len(trace)) if markings[start] == last]
    line = len(trace) - (len(rows[-1]) if rows else 0)
    if not any(net.is_enabled(t, last) for t in range(len(net.transitions))):
        returns = [len(trace)]  # nothing is fired any more
    for start in sorted(returns, key=lambda start: (start != line, -start)):
        stem, loop = tuple(trace[:start]), tuple(trace[start:])
        try:
            check_counterexample(net, formula, atoms, stem, loop, weak, strong)
        except ReplayError:
            continue
        return stem, loop
    raise TinaAnswerError("the counterexample of selt does not violate the formula")
