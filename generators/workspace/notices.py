"""Results of a comparison: files to write, notices for developers, and edits that prevent writing."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Change:
    """A file to be changed.

    Attributes
    ----------
    path : str
        Its path in the workspace.
    what : {"new", "changed", "restored", "extended", "removed"}
        The kind of change.
    detail : str
        Details, such as the stubs that are added.
    content : bytes or None
        The new content; None: the file is removed.
    """

    path: str
    what: str
    detail: str = ""
    content: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Notice:
    """Information for the developer of a file.

    Attributes
    ----------
    rule : {"obsolete-handler", "left-over", "token-changed", "arcs-changed", "kept"}
        Its subject.
    path : str
        The file.
    line : int or None
        The line in the file.
    message, hint : str
        The text, and what to do about it.
    stays : bool
        Whether it stays true until the developer acts, so that a check must fail; else it is only news.
    """

    rule: str
    path: str
    message: str
    hint: str = ""
    line: int | None = None
    stays: bool = False

    def __str__(self) -> str:
        where = f"{self.path}:{self.line}" if self.line else self.path
        return f"{where}: {self.message}{f' ({self.hint})' if self.hint else ''} [{self.rule}]"


@dataclass(frozen=True)
class Edit:
    """An edited generated file; `difference` is a unified diff from the intended content."""

    path: str
    message: str
    difference: str
