"""What can be composed of commands, and how it is read from what a stranger may have sent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, get_args

from dineros.metamodel.editing.commands import decode, kind_of


@dataclass(frozen=True)
class Copy:
    """Copy elements, with their parts and the arcs between them, shifted by `dx` and `dy`.

    Signals that their clauses speak of come along where the ROS node they are copied into lacks them. The
    copies are called `$copy1`, `$copy2`, and so on, in the order of `elements`.

    Attributes
    ----------
    elements : tuple of str
        What to copy; deleted elements too.
    owner : str
        The page, or the model, that gets the copies.
    dx, dy : float
        How far from the originals they stand.
    """

    elements: tuple[str, ...]
    owner: str
    dx: float
    dy: float


@dataclass(frozen=True)
class Into:
    """Move elements of one page into another page of the same ROS node.

    Arcs that would leave a page lead to reference places instead, and references that come to stand beside
    their places become these.
    """

    elements: tuple[str, ...]
    page: str


@dataclass(frozen=True)
class Group:
    """Make a page of elements of a page, as `Into` does; it is called `$page`.

    Attributes
    ----------
    elements : tuple of str
        What goes into it.
    type : str
        ``pn.Page`` or ``sym.CallbackPage``.
    """

    elements: tuple[str, ...]
    type: str = "pn.Page"


@dataclass(frozen=True)
class Split:
    """Put what stands on a page onto the page around it, and take the page away."""

    page: str


@dataclass(frozen=True)
class Fill:
    """Let a balloon token carry a value in a field of its token type.

    Attributes
    ----------
    token : str
        The balloon token.
    field : str
        The name of a field.
    text : str or None
        The value: as it is for texts, else as JSON. None: the default of the field.
    """

    token: str
    field: str
    text: str | None


@dataclass(frozen=True)
class Insert:
    """Put a template into a system model, its upper left corner at a point; see `templates`."""

    template: str
    x: float
    y: float


@dataclass(frozen=True)
class Join:
    """Draw an arc between two pages of a ROS node; a reference stands for the place beside the other end.

    Attributes
    ----------
    source, target : str
        What the arc leads from and to.
    x, y : float
        Where the reference stands, on the page of the other end, where none stands for the place there.
    """

    source: str
    target: str
    x: float
    y: float


Operation: TypeAlias = Copy | Into | Group | Split | Join | Fill | Insert

OPERATIONS: dict[str, type[Operation]] = {kind_of(each): each for each in get_args(Operation)}
"""All operations, by what they are called in messages."""


def decode_operation(found: object) -> Operation:
    """Read an operation from JSON values, such as ``{"kind": "split", "page": "e3"}``.

    Raises
    ------
    CommandError
        It is none; the message names the field.
    """
    return decode(found, OPERATIONS, "the operation")
