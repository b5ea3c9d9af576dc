"""Writing small PNML files by hand, and reading what we write."""

from __future__ import annotations

import textwrap
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import arcs, nodes, pages
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml
from dineros.metamodel.files.pnml.vocabulary import Version

PNML = "http://www.pnml.org/version-2009/grammar/pnml"
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"
DINEROS = "de.tudresden.inf.st.pnml.distributedPN"


def document(net: str) -> str:
    """Return a PNML file with one net around the given pages and labels."""
    body = textwrap.dedent(net).strip()
    start = f'<?xml version="1.0"?>\n<pnml xmlns="{PNML}">\n<net id="net" type="{PTNET}">'
    return f"{start}\n{body}\n</net>\n</pnml>\n"


def dineros(fields: str, version: str = "0.2") -> str:
    """Return a block of the DiNeROS extension."""
    return f'<toolspecific tool="{DINEROS}" version="{version}">{fields}</toolspecific>'


def read_text(folder: Path, text: str) -> pn.Net:
    """Return the net in a PNML text."""
    file = folder / "model.pnml"
    file.write_text(text, encoding="utf-8")
    return read_pnml(file)


def read_net(folder: Path, net: str) -> pn.Net:
    """Return the net made of the given pages and labels."""
    return read_text(folder, document(net))


def read_system(folder: Path, net: str) -> sym.SystemModel:
    """Return the system model made of the given pages and labels."""
    model = read_net(folder, net)
    assert isinstance(model, sym.SystemModel)
    return model


def again(folder: Path, net: pn.Net, version: Version = "0.2") -> pn.Net:
    """Return what reading gives after writing."""
    return read_text(folder, pnml_bytes(net, version).decode())


def drawing(net: pn.Net) -> dict[str, list[str]]:
    """Return the ids on every page: node and page ids, and arcs as ``source>target``."""
    result = {
        page.id: [
            *(each.id for each in page.objects),
            *(f"{arc.source.id}>{arc.target.id}" for arc in page.arcs),
        ]
        for page in pages(net)
    }
    assert sum(len(page.arcs) for page in pages(net)) == len(list(arcs(net)))
    assert len({node.id for node in nodes(net)}) == len(list(nodes(net)))
    return result
