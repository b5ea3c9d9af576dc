"""Formats that hold nets only and refer to no other file; XMI files may refer to files in them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.metamodel.errors import Location, ModelFileError, with_article

if TYPE_CHECKING:
    from dineros.metamodel import pn
    from dineros.metamodel.base import EObject

SUFFIXES_OF_NETS = (".pnml", ".net", ".xml", ".cts")


def net_format(suffix: str) -> tuple[Callable[[Path], EObject], Callable[[EObject, Path], None]]:
    """Return reader and writer for one of `SUFFIXES_OF_NETS`; a format's modules are imported here."""
    if suffix == ".pnml":
        from dineros.metamodel.files.pnml import read_pnml, write_pnml

        return read_pnml, _for_nets(write_pnml)
    if suffix == ".xml":
        from dineros.metamodel.files.romeo import read_romeo, write_romeo

        return read_romeo, _for_nets(write_romeo)
    if suffix == ".cts":
        from dineros.metamodel.files.romeo import read_cts, write_cts

        return read_cts, _for_nets(write_cts)
    from dineros.metamodel.files.tina import read_net, write_net

    return read_net, _for_nets(write_net)


def _for_nets(write: Callable[[pn.Net, Path], None]) -> Callable[[EObject, Path], None]:
    from dineros.metamodel import pn

    def write_net(root: EObject, path: Path) -> None:
        if not isinstance(root, pn.Net):
            raise ModelFileError(
                f"this format cannot hold {with_article(root.eClass.name)}",
                location=Location(path),
                hint="use .xmi",
            )
        write(root, path)

    return write_net
