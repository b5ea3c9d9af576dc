"""Origins of the places and transitions of an unfolded net in the coloured net."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dineros.metamodel.base import EObject


@dataclass(frozen=True)
class Origins:
    """Ids of the unfolded net by ids of the coloured net; empty for elements without possible colours.

    Attributes
    ----------
    places, transitions : mapping of str to tuple of str
        By id of the coloured place or transition.
    """

    places: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    transitions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def remember_origins(net: EObject, origins: Origins) -> None:
    """Keep the origins with a net that was unfolded."""
    net.__dict__["_origins"] = origins


def origins_of(net: EObject) -> Origins:
    """Return the origins of a net; they are empty if it was not unfolded."""
    origins: Origins = net.__dict__.get("_origins", Origins())
    return origins
