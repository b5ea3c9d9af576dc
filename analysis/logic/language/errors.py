"""Errors of temporal logic: an invalid formula, or one that refers to unknown elements."""

from __future__ import annotations

from dineros.metamodel.errors import DinerosError


class FormulaError(DinerosError):
    """The text is not a formula, or has an unknown name.

    Parameters
    ----------
    column : int, optional
        Position in the text, from 1.
    """

    def __init__(self, message: str, *, column: int | None = None, hint: str | None = None) -> None:
        super().__init__(message, hint=hint)
        self.column = column

    def at(self, column: int | None) -> FormulaError:
        """Return the same error with a column, if it has none yet."""
        return FormulaError(self.message, column=self.column or column, hint=self.hint)

    def __str__(self) -> str:
        if not self.column:
            return super().__str__()
        message = f"column {self.column}: {self.message}"
        return str(DinerosError(message, location=self.location, hint=self.hint))
