"""TINA's textual format ``.net`` for place/transition and time Petri nets (LAAS-CNRS, manual page "formats").

Read are all declarations (``net tr pl lb pr nt``, see `parsing`) with weights and their factors (``2K``),
read and inhibitor arcs, intervals and priorities. Several declarations of one node add up. Stopwatch arcs are
refused: nets have none. Bounds may be decimal (``0.25``) or rational (``1/3``) and stay exact; TINA itself
takes whole numbers only.

Written are nodes and what they do. References are resolved and pages dropped; layout, notes of other tools
and the data of tokens have no place in this format. Nodes are named by their ids and labelled by their names.
Channels and clauses are errors, as their meaning would be lost.

Where a transition takes tokens from a place that it also reads, TINA compares the marking with the weight of
the read arc alone and DiNeROS with the sum, since a read arc is short for a pair of normal arcs; reading and
writing convert.
"""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import pn
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import collector_paused, read_bytes
from dineros.metamodel.files.tina.reader import net_from_text
from dineros.metamodel.files.tina.writer import net_text
from dineros.metamodel.positions import remember_file

__all__ = ["net_from_text", "net_text", "read_net", "write_net"]


def read_net(path: Path | str) -> pn.Net:
    """Return the net in a ``.net`` file, on one page.

    Ids are the names in the file, with ``_`` for white space; labels become names.

    Raises
    ------
    ModelFileError
        The file cannot be read, is not in this format, or holds what a net cannot: with line and column.
    """
    content = read_bytes(path)
    with collector_paused():
        net = net_from_text(content, Path(path))
    remember_file(net, Path(path))
    return net


def write_net(net: pn.Net, path: Path | str) -> None:
    """Write a net; equal nets give equal bytes, and a crash leaves the old file.

    Raises
    ------
    ModelFileError
        The file cannot be written, or the net has channels, clauses, or bounds of intervals below 0.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    write_atomically(path, net_text(net, Path(path)).encode())
    remember_file(net, Path(path))
