"""EMF's XMI: the files Eclipse and pyecore read and write (OMG XMI 2.0 as EMF lays it out).

Containment is nesting, attributes are XML attributes in the order of the metamodel, references are lists of
ids, or fragments such as ``//@pages.0/@objects.1`` where the target has none, and references into other files
are elements with ``href="other.xmi#id"``. Default values are left out, unless the feature is mandatory.

pyecore has an XMI resource of its own; it forgets lines, accepts unknown literals, and writes in the order in
which features happened to be set, so that equal models give different files.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from dineros.metamodel.base import EObject
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import collector_paused
from dineros.metamodel.files.xmi.reader import XmiReader
from dineros.metamodel.files.xmi.writer import xmi_bytes
from dineros.metamodel.positions import remember_file

__all__ = ["read_xmi", "write_xmi", "xmi_bytes"]


def read_xmi(path: Path | str, models: Iterable[EObject] = (), content: bytes | None = None) -> EObject:
    """Return the root of a model file.

    Parameters
    ----------
    path : Path or str
        The file.
    models : iterable of EObject
        Roots that were loaded or saved before: references into their files lead to their very objects.
    content : bytes, optional
        What the file holds; read from it unless given.

    Raises
    ------
    ModelFileError
        The file, or one it refers to, cannot be read or holds no valid model; with line and near matches.
    """
    with collector_paused():
        return XmiReader(models).read(Path(path), content)


def write_xmi(root: EObject, path: Path | str) -> None:
    """Write a model; equal models give equal bytes, and a crash leaves the old file.

    Raises
    ------
    ModelFileError
        The file cannot be written, or the model cannot be stored: an id is missing, used twice or has white
        space, a reference leads out of the model to one that was never in a file, a text holds characters
        that XML cannot carry, or it nests deeper than 250 elements.
    """
    write_atomically(path, xmi_bytes(root, Path(path)))
    remember_file(root, Path(path))
