"""Formats that hold nets only and refer to no other file; XMI files may refer to files in them."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import Location, ModelFileError, with_article
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import collector_paused, read_bytes

if TYPE_CHECKING:
    from dineros.metamodel import pn
    from dineros.metamodel.base import EObject

SUFFIXES_OF_NETS = (".pnml", ".net", ".xml", ".cts")

_TEXTS = {
    ".net": ("tina", "net_from_text", "net_text"),
    ".xml": ("romeo", "net_from_content", "net_content"),
    ".cts": ("romeo", "net_from_cts", "cts_text"),
}
"""For each suffix: the module of the format, what parses the content of a file, and what makes it."""


def net_format(suffix: str) -> tuple[Callable[[Path], EObject], Callable[[EObject, Path], None]]:
    """Return reader and writer for one of `SUFFIXES_OF_NETS`; a format's modules are imported here."""
    if suffix == ".pnml":
        from dineros.metamodel.files.pnml import read_pnml, write_pnml

        return read_pnml, _for_nets(write_pnml)
    from dineros.metamodel.positions import remember_file

    name, parse, text = _TEXTS[suffix]
    module: Any = import_module(f"dineros.metamodel.files.{name}")

    def read_net(path: Path) -> pn.Net:
        content = read_bytes(path)
        with collector_paused():
            net: pn.Net = getattr(module, parse)(content, path)
        remember_file(net, path)
        return net

    def write_net(net: pn.Net, path: Path) -> None:
        content: str | bytes = getattr(module, text)(net, path)
        write_atomically(path, content if isinstance(content, bytes) else content.encode())
        remember_file(net, path)

    return read_net, _for_nets(write_net)


def _for_nets(write: Callable[[pn.Net, Path], None]) -> Callable[[EObject, Path], None]:
    from dineros.metamodel import pn

    def write_if_net(root: EObject, path: Path) -> None:
        if not isinstance(root, pn.Net):
            raise ModelFileError(
                f"this format cannot hold {with_article(root.eClass.name)}",
                location=Location(path),
                hint="use .xmi",
            )
        write(root, path)

    return write_if_net
