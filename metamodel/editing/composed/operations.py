"""Operations composed of commands, and how they are read from untrusted data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, get_args

from dineros.metamodel.editing.commands import decode, kind_of


@dataclass(frozen=True)
class Copy:
    """Copy elements, with their parts and the arcs between them, shifted by `dx` and `dy`.

    Signals in their clauses are copied, too, if the target ROS node lacks them. The copies are named
    `$copy1`, `$copy2`, and so on, in the order of `elements`.

    Attributes
    ----------
    elements : tuple of str
        The elements to copy, which may be deleted ones.
    owner : str
        The page, or the model, that contains the copies.
    dx, dy : float
        Distance of the copies from the originals.
    """

    elements: tuple[str, ...]
    owner: str
    dx: float
    dy: float


@dataclass(frozen=True)
class Into:
    """Move elements of one page into another page of the same ROS node.

    Arcs that would cross pages are connected to reference places instead. References on the same page as
    their places are replaced by these.
    """

    elements: tuple[str, ...]
    page: str


@dataclass(frozen=True)
class Group:
    """Make a page from elements of a page, like `Into`; the page is named `$page`.

    Attributes
    ----------
    elements : tuple of str
        The elements of the new page.
    type : str
        ``pn.Page`` or ``sym.CallbackPage``.
    """

    elements: tuple[str, ...]
    type: str = "pn.Page"


@dataclass(frozen=True)
class Split:
    """Move the contents of a page to the page around it, and delete the page."""

    page: str


@dataclass(frozen=True)
class Fill:
    """Set a field of a balloon token.

    Attributes
    ----------
    token : str
        The balloon token.
    field : str
        The name of a field.
    text : str or None
        The value: literally for texts, else as JSON. None: the default of the field.
    """

    token: str
    field: str
    text: str | None


@dataclass(frozen=True)
class Insert:
    """Insert a template into a system model, with its upper left corner at a point; see `templates`."""

    template: str
    x: float
    y: float


@dataclass(frozen=True)
class Join:
    """Draw an arc between two pages of a ROS node; a reference represents the place on the other page.

    Attributes
    ----------
    source, target : str
        The ends of the arc.
    x, y : float
        Position of the reference, on the page of the other end, if the place has none there.
    """

    source: str
    target: str
    x: float
    y: float


Operation: TypeAlias = Copy | Into | Group | Split | Join | Fill | Insert

OPERATIONS: dict[str, type[Operation]] = {kind_of(each): each for each in get_args(Operation)}
"""All operations, by their names in messages."""


def decode_operation(found: object) -> Operation:
    """Read an operation from JSON values, such as ``{"kind": "split", "page": "e3"}``.

    Raises
    ------
    CommandError
        It is not an operation; the message names the field.
    """
    return decode(found, OPERATIONS, "the operation")
