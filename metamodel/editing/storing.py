"""The bytes of a model that is edited: those it was read from where nothing changed, and around what changed.

A file that we wrote is written in our own form again. In a file that somebody else wrote, only what changed
becomes different, if its form allows that, which is seen by reading it again; else it is written in our form.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.editing.patching import NoPatchError, patched
from dineros.metamodel.errors import DinerosError, Location, ModelFileError, with_article

SUFFIXES = (".xmi", ".sym", ".rtm", ".pnm", ".pnml")
"""Of files that can be edited."""


@dataclass(frozen=True)
class Content:
    """What a file is to hold.

    Attributes
    ----------
    data : bytes
        Its bytes.
    keeps_form : bool
        Whether all that did not change stays as it stands in the file; else the file is written in our form.
    """

    data: bytes
    keeps_form: bool


def read_content(content: bytes, path: Path) -> pn.Net:
    """Return the net in bytes that stand, or stood, in a file.

    Raises
    ------
    ModelFileError
        They hold no net.
    """
    if path.suffix.lower() == ".pnml":
        from dineros.metamodel.files.pnml import read_pnml

        return read_pnml(path, content)
    from dineros.metamodel.files.xmi import read_xmi

    root = read_xmi(path, content=content)
    if not isinstance(root, pn.Net):
        raise ModelFileError(f"holds {with_article(root.eClass.name)}, not a net", location=Location(path))
    return root


def own_form(net: pn.Net, path: Path) -> bytes:
    """Return a net as we write it into a file of this name.

    Raises
    ------
    ModelFileError
        The format cannot hold the net.
    """
    if path.suffix.lower() == ".pnml":
        from dineros.metamodel.files.pnml import pnml_bytes

        return pnml_bytes(net)
    from dineros.metamodel.files.xmi import xmi_bytes

    return xmi_bytes(net, path)


def new_net(path: Path) -> pn.Net:
    """Return an empty system model for a file that is not there yet."""
    stem = path.name.partition(".")[0]
    id = "".join(each if each.isalnum() or each in "_-" else "_" for each in stem) or "model"
    return sym.SystemModel(id=id, middleware="ros2")


class Form:
    """How the file of a model is written: what it held, and the model in it, in our form.

    Parameters
    ----------
    path : Path
        The file.
    original : bytes or None
        What it held when the model was read; None: there was none.
    net : pn.Net
        The model, as it was read.
    """

    def __init__(self, path: Path, original: bytes | None, net: pn.Net) -> None:
        self._path = path
        self._original = original
        self._before = None if original is None else own_form(net, path)

    def content(self, net: pn.Net) -> Content:
        """Return what the file is to hold for the model as it is now.

        Raises
        ------
        ModelFileError
            The format cannot hold the model.
        """
        after = own_form(net, self._path)
        if self._original is None or self._original == self._before:
            return Content(after, True)
        assert self._before is not None
        if after == self._before:
            return Content(self._original, True)
        try:
            data = patched(self._original, self._before, after)
            if own_form(read_content(data, self._path), self._path) == after:
                return Content(data, True)
        except (NoPatchError, DinerosError):
            pass  # in our form, then
        return Content(after, False)
