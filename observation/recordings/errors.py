"""The error of this package."""

from dineros.metamodel.errors import DinerosError


class RecordingError(DinerosError):
    """A recording cannot be read: it is damaged, cut off, empty, or not a recording."""
