"""The error of this package."""

from __future__ import annotations

from dineros.metamodel.errors import DinerosError


class TracingError(DinerosError):
    """Tracing files cannot be read: they are damaged, cut off, empty, or none."""
