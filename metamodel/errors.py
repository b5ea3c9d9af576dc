"""The one error hierarchy of DiNeROS.

Every error a user can cause derives from `DinerosError` and prints as one line,
``FILE:LINE: message (hint)``, which is what the command line shows.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

_UNSEEN = {"Cc", "Cf", "Zl", "Zp"}
"""Unicode's categories of invisible characters: controls, formats, ends of lines and paragraphs."""

LEAST_PART = 4
"""Letters with which another name begins or ends, at least, to be near it."""

SHOWN = 2000
"""Characters of an error that are shown: what is wrong with an input may quote all of it."""


def without_middle(line: str) -> str:
    """Leave out the middle of a long line: the location is at the start, and the hint at the end."""
    return line if len(line) <= SHOWN else f"{line[: SHOWN // 2]} ... {line[-SHOWN // 2 :]}"


def printable(text: str) -> str:
    r"""Return a text as one line that steers no terminal.

    The content of files is data: a line break would begin a line that looks like one of ours, an escape
    sequence would steer the terminal, and a mark of direction would change the order of what is read. Each is
    shown as Python writes it, such as ``\n``. Tabs stay.
    """
    if text.isprintable():
        return text
    return "".join(
        repr(each)[1:-1] if each != "\t" and unicodedata.category(each) in _UNSEEN else each for each in text
    )


@dataclass(frozen=True)
class Location:
    """A location: a file, a line (from 1) and a column (from 1), as far as they are known."""

    file: Path | str | None = None
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        parts = [str(part) for part in (self.file, self.line, self.column) if part is not None]
        return ":".join(parts)


class DinerosError(Exception):
    """Wrong use or bad input; the message has the fault, its place, and a remedy.

    Parameters
    ----------
    message : str
        What is wrong, in one line.
    location : Location, optional
        Where it is wrong.
    element : str, optional
        Id of the model element concerned.
    hint : str, optional
        What would fix it.
    """

    def __init__(
        self,
        message: str,
        *,
        location: Location | None = None,
        element: str | None = None,
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.location = location
        self.element = element
        self.hint = hint

    def __str__(self) -> str:
        where = f"{self.location}: " if self.location and str(self.location) else ""
        hint = f" ({self.hint})" if self.hint else ""
        return without_middle(printable(" ".join(f"{where}{self.message}{hint}".split())))


class BudgetError(DinerosError):
    """Memory ran out before there was an answer: neither wrong use nor bad input (exit status 3)."""


class ModelFileError(DinerosError):
    """A file cannot be read or written, or does not hold a model."""


class CollectedModelFileError(ModelFileError):
    """All errors of a file that does not hold a model, if there are several.

    Prints as the first error and how many follow.

    Parameters
    ----------
    errors : sequence of ModelFileError
        Two or more, in the order of the file.
    """

    def __init__(self, errors: Sequence[ModelFileError]) -> None:
        first, more = errors[0], len(errors) - 1
        super().__init__(
            f"{first.message}; and {more} more error{'s' if more > 1 else ''}",
            location=first.location,
            element=first.element,
            hint=first.hint,
        )
        self.errors = tuple(errors)


def raise_collected(errors: Iterable[ModelFileError]) -> None:
    """Raise the errors of one or more files, in the order of files and lines; do nothing if there are none.

    Raises
    ------
    ModelFileError
        The one error; `CollectedModelFileError` for more than one.
    """
    files: dict[str, int] = {}

    def place(error: ModelFileError) -> tuple[int, int]:
        where = error.location or Location()
        return files.setdefault(str(where.file), len(files)), where.line or 0

    ordered = sorted(errors, key=place)
    if ordered:
        raise ordered[0] if len(ordered) == 1 else CollectedModelFileError(ordered)


class UnknownFeatureError(DinerosError, AttributeError):
    """A model class has no feature of this name."""


class FeatureValueError(DinerosError, TypeError):
    """A value does not fit the type of its feature."""


class ClauseError(DinerosError):
    """The text of an input clause is not a boolean expression over signals of its node net.

    `column` counts from 1 in the text; it is absent if the mistake has no position.
    """

    def __init__(self, message: str, *, column: int | None = None, hint: str | None = None) -> None:
        super().__init__(message, hint=hint)
        self.column = column


class GuardError(DinerosError):
    """A guard or an assignment cannot be read, or names fields that are not there."""


class UnknownElementError(DinerosError):
    """A model has no element of this name."""


def with_article(noun: str) -> str:
    """Return a noun behind its indefinite article, by its first letter.

    Examples
    --------
    >>> [with_article(noun) for noun in ("integer", "Place", "Arc", "unit")]
    ['an integer', 'a Place', 'an Arc', 'a unit']
    """
    return f"{'an' if noun[:1].lower() in 'aeio' else 'a'} {noun}"


def counted(number: int, noun: str) -> str:
    """Return a number of things.

    Examples
    --------
    >>> counted(1, "step"), counted(1200, "new file")
    ('1 step', '1,200 new files')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def listed(names: Iterable[str]) -> str:
    """Return the first of some names, and the number of others.

    Examples
    --------
    >>> listed("abcab"), listed("abcdef")
    ('a, b, c', 'a, b, c and 3 more')
    """
    known = list(dict.fromkeys(names))
    return ", ".join(known[:3]) + (f" and {len(known) - 3} more" if len(known) > 3 else "")


def near_matches(name: str, known: Iterable[str]) -> str | None:
    """Return a hint such as ``did you mean 'tokens'?``, or None if nothing known is near `name`.

    Near are names that differ in few letters, for their length, or in case and separators only, and those
    that begin or end with the other one. A hint that is only similar would lead astray.

    Examples
    --------
    >>> near_matches("tokns", ["tokens", "name"]), near_matches("kind", ["id"])
    ("did you mean 'tokens'?", None)
    """
    import difflib

    similar = difflib.get_close_matches(name, list(dict.fromkeys(known)), n=8, cutoff=0.6)
    near = [each for each in similar if _is_near(name, each)][:3]
    return f"did you mean {' or '.join(repr(match) for match in near)}?" if near else None


def _is_near(name: str, other: str) -> bool:
    one, two = (re.sub(r"[\W_]", "", each).casefold() for each in (name, other))
    shorter, longer = sorted((one, two), key=len)
    if one == two or (len(shorter) >= LEAST_PART and longer.endswith(shorter)):
        return True
    if longer.startswith(shorter):
        return 0 < len(longer) <= 2 * len(shorter)
    return len(shorter) > 1 and _edits(one, two) <= 1 + len(shorter) // 4


def _edits(one: str, two: str) -> int:
    """Return how many letters are to be inserted, removed, replaced or exchanged with the next one."""
    before: list[int] = []
    row = list(range(len(two) + 1))
    for i, letter in enumerate(one, 1):
        last, before, row = before, row, [i]
        for j, other in enumerate(two, 1):
            cost = min(before[j] + 1, row[-1] + 1, before[j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == two[j - 2] and one[i - 2] == other:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
    return row[-1]
