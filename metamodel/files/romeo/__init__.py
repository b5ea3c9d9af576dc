"""Romeo's formats for time Petri nets (LS2N Nantes): its drawings ``.xml``, and its language ``.cts``.

Read are initial markings, intervals with open and closed bounds, weights, read and logical inhibitor arcs,
and priorities. Features that time Petri nets lack are errors, reported with their line: stopwatches, timed
inhibitor arcs, speeds, processors, parameters, flush arcs, coloured tokens, guards, updates, and intervals of
places. Costs, and which transitions can be observed or controlled, change no behaviour and are not kept.

Where a transition takes tokens from a place that it also reads, Romeo compares the marking with the weight of
the read arc alone and DiNeROS with the sum; reading and writing convert, as for TINA.

Of ``.cts``, the part is read in which Romeo itself writes time Petri nets; see `cts_reader`.

In Romeo, a transition with a higher number goes before all with a lower one. Relations between single
transitions are written if such numbers can say them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dineros.metamodel import pn
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import collector_paused, read_bytes
from dineros.metamodel.files.romeo.cts_reader import net_from_cts
from dineros.metamodel.files.romeo.cts_writer import cts_text
from dineros.metamodel.files.romeo.reader import net_from_content
from dineros.metamodel.files.romeo.writer import net_content
from dineros.metamodel.positions import remember_file

__all__ = [
    "cts_text",
    "net_content",
    "net_from_content",
    "net_from_cts",
    "read_cts",
    "read_romeo",
    "write_cts",
    "write_romeo",
]


def read_cts(path: Path | str) -> pn.Net:
    """Return the net in a ``.cts`` file, on one page; ids are the names in the file.

    Raises
    ------
    ModelFileError
        The file cannot be read, is not in this format, or says what a time Petri net cannot; with line.
    """
    return _read(path, net_from_cts)


def write_cts(net: pn.Net, path: Path | str) -> None:
    """Write a net in Romeo's language; equal nets give equal bytes, and a crash leaves the old file.

    Raises
    ------
    ModelFileError
        The file cannot be written, or the net holds what the format cannot say.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    _write(net, path, cts_text(net, Path(path)).encode())


def read_romeo(path: Path | str) -> pn.Net:
    """Return the net in a Romeo file, on one page.

    Ids are the identifiers in the file, or labels where a file of an old version has none.

    Raises
    ------
    ModelFileError
        The file cannot be read, is not in this format, or holds what a time Petri net cannot; with line.
    """
    return _read(path, net_from_content)


def write_romeo(net: pn.Net, path: Path | str) -> None:
    """Write a net; equal nets give equal bytes, and a crash leaves the old file.

    Raises
    ------
    ModelFileError
        The file cannot be written, or the net holds what the format cannot say.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    _write(net, path, net_content(net, Path(path)))


def _read(path: Path | str, parse: Callable[[bytes, Path], pn.Net]) -> pn.Net:
    content = read_bytes(path)
    with collector_paused():
        net = parse(content, Path(path))
    remember_file(net, Path(path))
    return net


def _write(net: pn.Net, path: Path | str, content: bytes) -> None:
    write_atomically(path, content)
    remember_file(net, Path(path))
