"""Which properties a model stores."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.metamodel import pn, sym


def properties_of(model: pn.Net) -> Sequence[sym.Property]:
    """Return the properties that a model stores; a plain net has none."""
    return tuple(model.properties) if isinstance(model, sym.SystemModel) else ()
