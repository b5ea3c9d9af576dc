"""State spaces counted by TINA, where the user has it on the PATH.

The net goes out as a ``.net`` file, ``tina -R -q`` builds its marking graph, and the digest that it prints
is read back. What is run and read is as TINA's manual describes it; this project has no copy of TINA to try
it with.

References
----------
B. Berthomieu, P.-O. Ribet, F. Vernadat, *The tool TINA: construction of abstract state spaces for Petri nets
and time Petri nets*, International Journal of Production Research 42(14), 2004.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from dineros.analysis.compiled import CompiledNet
from dineros.metamodel.errors import DinerosError

#: Rows of the digest, such as ``#      states      12     5     ?     0     12``.
_ROW = re.compile(r"^#\s*(states|transitions)\s+(\d+)\s+\S+\s+\S+\s+(\S+)\s+\S+\s*$", re.MULTILINE)
#: The size of the net as TINA has read it: ``# net N, 6 places, 6 transitions, 14 arcs``.
_SIZE = re.compile(r"(\d+) places, (\d+) transitions")


class TinaError(DinerosError):
    """TINA is not there, failed, or printed what cannot be read."""


@dataclass(frozen=True)
class TinaCounts:
    """What TINA counted.

    Attributes
    ----------
    states, arcs : int
        Markings, and arcs between them.
    deadlocks : int or None
        Markings that enable nothing, where TINA tells.
    is_bounded : bool
        Whether it found the net bounded; otherwise the counts are those of what it looked at.
    """

    states: int
    arcs: int
    deadlocks: int | None
    is_bounded: bool


def tool(name: str = "tina") -> Path:
    """Return where a tool of TINA is.

    Raises
    ------
    TinaError
        It is not on the PATH.
    """
    found = shutil.which(name)
    if found is None:
        raise TinaError(
            f"{name} is not on the PATH",
            hint="TINA is to be had from its authors at LAAS; or use another engine",
        )
    return Path(found)


def count(net: CompiledNet, seconds: float | None = None) -> TinaCounts:
    """Let TINA build the marking graph of a net.

    Parameters
    ----------
    net : CompiledNet
        The net.
    seconds : float, optional
        How long it may take.

    Raises
    ------
    TinaError
        TINA is not there, failed, took too long, or read another net than was written.
    """
    from dineros.analysis.nets import to_model
    from dineros.metamodel.files import save

    program = tool()
    with tempfile.TemporaryDirectory(prefix="dineros-tina-") as folder:
        path = Path(folder) / "net.net"
        save(to_model(net, "net"), path)
        try:
            # -R: the marking graph; -q: nothing but the digest.
            answer = subprocess.run(
                [str(program), "-R", "-q", str(path)],
                capture_output=True,
                text=True,
                errors="replace",
                timeout=seconds,
                check=False,
                cwd=folder,
            )
        except subprocess.TimeoutExpired:
            raise TinaError(f"tina took more than {seconds:g} s") from None
        except OSError as error:
            raise TinaError(f"{program} does not run: {error.strerror}") from None
    printed = answer.stdout + "\n" + answer.stderr
    if answer.returncode:
        last = next((line for line in reversed(printed.splitlines()) if line.strip()), "no message")
        raise TinaError(f"tina failed with exit status {answer.returncode}: {last.strip()}")
    size = _SIZE.search(printed)
    if size and (int(size[1]), int(size[2])) != (len(net.places), len(net.transitions)):
        raise TinaError(
            f"tina has read {size[1]} places and {size[2]} transitions,"
            f" where the net has {len(net.places)} and {len(net.transitions)}"
        )
    return read_digest(printed)


def read_digest(printed: str) -> TinaCounts:
    """Read the counts off the digest of ``tina -R``.

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
    if not {"states", "transitions"} <= rows.keys():
        raise TinaError("what tina printed holds no digest with states and transitions")
    dead = rows["states"][1]
    return TinaCounts(
        rows["states"][0],
        rows["transitions"][0],
        int(dead) if dead.isdigit() else None,
        re.search(r"\b(unbounded|not bounded)\b", printed) is None,
    )


def differences(net: CompiledNet, counts: TinaCounts, memory: int) -> list[str]:
    """Compare what TINA counted with an engine of ours; a line for each figure that differs.

    Raises
    ------
    TinaError
        The engine could not count all within its memory.
    """
    from dineros.analysis.statespace import state_space

    space = state_space(net, memory=memory)
    if not space.complete:
        if not counts.is_bounded and "bound" in space.reason:
            return []
        raise TinaError(f"nothing to compare with: {space.reason}")
    pairs = {
        "states": (counts.states, space.states),
        "arcs": (counts.arcs, space.arcs),
        "deadlocks": (counts.deadlocks, space.deadlocks),
    }
    return [
        f"{name}: {theirs} by tina, {ours} by the {space.engine} engine"
        for name, (theirs, ours) in pairs.items()
        if theirs is not None and ours is not None and theirs != ours
    ]
