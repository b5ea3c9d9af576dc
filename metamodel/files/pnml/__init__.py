"""PNML, the XML format of Petri nets (ISO/IEC 15909-2), with the DiNeROS extension.

A file of plain PNML becomes a `pn.Net` (package `plain` says which forms of other tools are read). A
symmetric net is unfolded (package `symmetric`). A file that uses the extension (``toolspecific`` blocks of
the tool ``de.tudresden.inf.st.pnml.distributedPN``, versions 0.1 and 0.2) becomes a `sym.SystemModel`.
The module `normalise` says what happens to files that keep a distributed model on one page. What PNML and the
extension cannot say is written into blocks of our own (module `own`), so that a model loses nothing on its
way through a file.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.metamodel.errors import ModelFileError, near_matches
from dineros.metamodel.files.pnml.vocabulary import VERSIONS, Version

if TYPE_CHECKING:
    from dineros.metamodel import pn

__all__ = ["pnml_bytes", "read_pnml", "write_pnml"]


def read_pnml(path: Path | str, content: bytes | None = None) -> pn.Net:
    """Return the net in a PNML file.

    Parameters
    ----------
    path : Path or str
        The file.
    content : bytes, optional
        What it holds; read from the file unless given.

    Raises
    ------
    ModelFileError
        The file cannot be read, is not a PNML file of one P/T net, or is wrong inside; with line and hint.
        `CollectedModelFileError` where more than one thing is wrong.
    ClauseError
        An input clause is not a boolean expression.
    """
    from dineros.metamodel.files.pnml.build import Builder
    from dineros.metamodel.files.pnml.normalise import normalise
    from dineros.metamodel.files.pnml.plain.dialect import is_symmetric, only_net
    from dineros.metamodel.files.pnml.read import read_records
    from dineros.metamodel.files.pnml.source import Source
    from dineros.metamodel.files.reading import collector_paused
    from dineros.metamodel.files.remarks import remember_remarks
    from dineros.metamodel.files.xml import parse, parse_bytes
    from dineros.metamodel.positions import remember_file

    source = Source(path)
    with collector_paused():
        tree = parse(path) if content is None else parse_bytes(content, path)
        xml = only_net(tree.getroot(), source)
        if is_symmetric(xml):
            from dineros.metamodel.files.pnml.symmetric.reader import read_symmetric

            net = read_symmetric(xml, source)
        else:
            records = read_records(xml, source)
            normalise(records, source)
            net = Builder(records, source).build()
    remember_remarks(net, source.notes)
    remember_file(net, Path(path))
    return net


def write_pnml(net: pn.Net, path: Path | str, version: Version = "0.2") -> None:
    """Write a net to a PNML file, atomically.

    Parameters
    ----------
    net : pn.Net
        A net of any of our metamodels.
    path : Path or str
        The file.
    version : {"0.2", "0.1"}
        Version of the DiNeROS extension; what 0.1 does not have goes into our own blocks.

    Raises
    ------
    ModelFileError
        The file cannot be written, or PNML cannot hold the net.
    """
    from dineros.metamodel.files.atomic import write_atomically
    from dineros.metamodel.positions import remember_file

    write_atomically(path, pnml_bytes(net, version))
    remember_file(net, Path(path))


def pnml_bytes(net: pn.Net, version: Version = "0.2") -> bytes:
    """Return a net as PNML text in UTF-8; equal nets give equal bytes.

    Raises
    ------
    ModelFileError
        PNML cannot hold the net.
    """
    from dineros.metamodel.files.pnml.write import Writer

    if version not in VERSIONS:
        message = f"version {version!r} of the DiNeROS extension is not known"
        raise ModelFileError(message, hint=near_matches(version, VERSIONS) or "versions are 0.1 and 0.2")
    return Writer(net, version).content()
