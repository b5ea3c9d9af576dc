"""Remarks of file readers on what they read in another way than the format specifies; shown once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dineros.metamodel.base import EObject


def remember_remarks(root: EObject, remarks: Iterable[str]) -> None:
    """Note, for the root of a model that was read, what was taken as what."""
    root.__dict__["_remarks"] = tuple(remarks)


def remarks_of(root: EObject) -> tuple[str, ...]:
    """Return what was noted when the model was read; nothing for a file that follows its format."""
    remarks: tuple[str, ...] = root.__dict__.get("_remarks", ())
    return remarks
