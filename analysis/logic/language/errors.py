"""Errors of the temporal logic: what a user wrote cannot be read, or cannot be meant."""

from __future__ import annotations

from dineros.metamodel.errors import DinerosError


class FormulaError(DinerosError):
    """The text of a formula is none, or names something that is not there.

    Parameters
    ----------
    message : str
        What is wrong, in one line.
    column : int, optional
        Where in the text, counted from 1.
    hint : str, optional
        What would mend it.
    """

    def __init__(self, message: str, *, column: int | None = None, hint: str | None = None) -> None:
        super().__init__(message, hint=hint)
        self.column = column

    def at(self, column: int | None) -> FormulaError:
        """Return the same error with a column, where it has none yet."""
        return FormulaError(self.message, column=self.column or column, hint=self.hint)

    def __str__(self) -> str:
        where = f"column {self.column}: " if self.column else ""
        return where + super().__str__()
