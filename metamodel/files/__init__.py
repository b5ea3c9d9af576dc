"""Reading and writing model files; the suffix of the file name chooses the format.

| suffix | format | may hold |
|---|---|---|
| ``.xmi``, ``.sym``, ``.rtm``, ``.pnm`` | EMF XMI | every model |
| ``.pnml`` | PNML (ISO/IEC 15909-2) with the DiNeROS extension | system models and plain nets |
| ``.net`` | TINA's textual format | plain nets |
| ``.xml`` | Romeo's format | plain nets |
| ``.cts`` | Romeo's language | plain nets |

Reading is safe for files from anywhere, writing is atomic and deterministic.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from dineros.metamodel.errors import Location, ModelFileError, near_matches, with_article
from dineros.metamodel.files.net_formats import SUFFIXES_OF_NETS, net_format
from dineros.metamodel.files.reading import cannot_read

if TYPE_CHECKING:
    from dineros.metamodel import pn
    from dineros.metamodel.base import EObject

__all__ = ["SUFFIXES", "load", "load_any", "require_file", "save"]

SUFFIXES = (".xmi", ".sym", ".rtm", ".pnm", *SUFFIXES_OF_NETS)
"""Suffixes of model files."""


def load(path: Path | str) -> pn.Net:
    """Return the net in a model file: a system model, a run-time model or a plain net.

    Raises
    ------
    ModelFileError
        The file cannot be read, or holds no net; with line and hint.
    """
    from dineros.metamodel import pn

    root = load_any(path)
    if not isinstance(root, pn.Net):
        raise ModelFileError(f"holds {with_article(root.eClass.name)}, not a net", location=Location(path))
    return root


def load_any(path: Path | str) -> EObject:
    """Return the root of a model file, which may be no net, such as a trace model.

    Raises
    ------
    ModelFileError
        The file cannot be read or holds no model; with line and hint.
    """
    read, _ = _format(path, _OTHER_FORMATS)
    return read(Path(path))


def require_file(path: Path) -> None:
    """Raise the error of `load` if a file does not exist, without importing what reads a format.

    Raises
    ------
    ModelFileError
        The file does not exist.
    """
    try:
        path.stat()
    except FileNotFoundError as error:
        if path.suffix.lower() not in (*SUFFIXES, ".py"):
            raise _unknown_suffix(path, _OTHER_FORMATS) from None
        raise cannot_read(Location(path), error) from error
    except (OSError, ValueError):
        return  # `load` says what is wrong


def save(net: EObject, path: Path | str) -> None:
    """Write a model; equal models give equal bytes, and a crash leaves the old file.

    Raises
    ------
    ModelFileError
        The file cannot be written, or its format cannot hold the model.
    """
    _, write = _format(path)
    write(net, Path(path))


_ELSEWHERE = "{} alone does not describe a Petri net; a tool such as {} exports one as PNML"
_OTHER_FORMATS = {
    ".tapn": "this is TAPAAL's own format: export the net as PNML there",
    ".ndr": "this is TINA's drawing: save it as .net, or use 'ndrio FILE.ndr FILE.net'",
    ".tpn": "this is a script of TINA: save the net as .net there",
    ".pnpro": "this is GreatSPN's project: export the net as PNML there",
    ".gspn": "this is GreatSPN's net: export it as PNML there",
    ".def": "this is GreatSPN's net: export it as PNML there",
    ".llnet": "this is a net of PEP: convert it to PNML, with APT for example",
    ".ll_net": "this is a net of PEP: convert it to PNML, with APT for example",
    ".pnt": "this is a net of INA: convert it to PNML",
    ".rnw": "this is a drawing of Renew: export the net as PNML there",
    **dict.fromkeys(
        (".spped", ".spept", ".andl"), "this is a net of Snoopy: export it as PNML or .net there"
    ),
    **dict.fromkeys(
        (".db3", ".mcap", ".bag"), "this is a recording: 'dineros import --bag' makes a model of it"
    ),
    ".apt": "this is a net of APT: convert it to PNML there",
    ".lola": "this is a net of LoLA: convert it to PNML",
    ".cpn": "this is a coloured net of CPN Tools: only P/T nets are read; unfold it and export PNML",
    ".bpmn": _ELSEWHERE.format("BPMN", "WoPeD or PM4Py"),
    ".bpmn2": _ELSEWHERE.format("BPMN", "WoPeD or PM4Py"),
    ".epml": _ELSEWHERE.format("EPML", "ProM"),
    ".ptml": _ELSEWHERE.format("a process tree", "PM4Py"),
    ".xes": _ELSEWHERE.format("an event log", "PM4Py"),
    **dict.fromkeys((".gz", ".xz", ".bz2", ".zst", ".zip", ".7z", ".tgz", ".tar"), "unpack it first"),
    ".ecore": "this is a metamodel; a model of it is an .xmi file",
}
"""What files of other tools are, by suffix; near suffixes would mislead."""


def _format(
    path: Path | str, others: Mapping[str, str] = MappingProxyType({})
) -> tuple[Callable[[Path], EObject], Callable[[EObject, Path], None]]:
    """Return reader and writer for a file name; modules of formats are imported when they are needed.

    `others` are hints by suffix for files of other tools.
    """
    suffix = Path(path).suffix.lower()
    if suffix in SUFFIXES_OF_NETS:
        return net_format(suffix)
    if suffix in SUFFIXES:
        from dineros.metamodel.files.xmi import read_xmi, write_xmi

        return read_xmi, write_xmi
    raise _unknown_suffix(path, others)


def _unknown_suffix(path: Path | str, others: Mapping[str, str]) -> ModelFileError:
    suffix = Path(path).suffix.lower()
    # A file that exists has no misspelt name: a near suffix would be advice to rename it.
    near = None if others and Path(path).exists() else near_matches(suffix, SUFFIXES)
    return ModelFileError(
        f"{suffix!r} is not a suffix of a model file" if suffix else "the file name has no suffix",
        location=Location(path),
        hint=others.get(suffix) or near or f"known are {', '.join(SUFFIXES)}",
    )
