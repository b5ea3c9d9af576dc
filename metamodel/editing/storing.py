"""The bytes of an edited model: unchanged parts of its file are preserved if possible.

A file written by us is written in our format again. In a file written by another program, only the changes
differ, if its form allows that, which is verified by reading the result; otherwise the file is written in our
format.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.editing.patching import NoPatchError, patched
from dineros.metamodel.errors import DinerosError, Location, ModelFileError, with_article

SUFFIXES = (".xmi", ".sym", ".rtm", ".pnm", ".pnml")
"""Suffixes of files that can be edited."""


@dataclass(frozen=True)
class Content:
    """The new content of a file.

    Attributes
    ----------
    data : bytes
        The bytes.
    keeps_form : bool
        Whether all unchanged parts of the file are preserved; otherwise the file is written in our format.
    """

    data: bytes
    keeps_form: bool


def read_content(content: bytes, path: Path) -> pn.Net:
    """Return the net in bytes that are or were the content of a file.

    Raises
    ------
    ModelFileError
        They contain no net.
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
    """Return a net in our format for a file of this name.

    Raises
    ------
    ModelFileError
        The format cannot represent the net.
    """
    if path.suffix.lower() == ".pnml":
        from dineros.metamodel.files.pnml import pnml_bytes

        return pnml_bytes(net)
    from dineros.metamodel.files.xmi import xmi_bytes

    return xmi_bytes(net, path)


def new_net(path: Path) -> pn.Net:
    """Return an empty system model for a file that does not exist yet."""
    stem = path.name.partition(".")[0]
    id = "".join(each if each.isalnum() or each in "_-" else "_" for each in stem) or "model"
    return sym.SystemModel(id=id, middleware="ros2")


class Form:
    """The form of a model's file: its content, and its model in our format.

    Parameters
    ----------
    path : Path
        The file.
    original : bytes or None
        Its content when the model was read; None: there was no file.
    net : pn.Net
        The model, as read.
    """

    def __init__(self, path: Path, original: bytes | None, net: pn.Net) -> None:
        self._path = path
        self._original = original
        self._before = None if original is None else own_form(net, path)

    def content(self, net: pn.Net) -> Content:
        """Return the new content of the file for the current model.

        Raises
        ------
        ModelFileError
            The format cannot represent the model.
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
            pass  # use our format
        return Content(after, False)
