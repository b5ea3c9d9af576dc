"""What a comparison finds: files to write, things that developers should know, edits that block it."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Change:
    """A file that is not as it should be.

    Attributes
    ----------
    path : str
        Its path in the workspace.
    what : {"new", "changed", "restored", "extended", "removed"}
        What happens to it.
    detail : str
        What of it, such as the stubs that are added.
    content : bytes or None
        What it will hold; None: it goes.
    """

    path: str
    what: str
    detail: str = ""
    content: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Notice:
    """Something that its developer should know.

    Attributes
    ----------
    rule : {"obsolete-handler", "left-over", "token-changed", "arcs-changed", "kept"}
        What it is about.
    path : str
        The file.
    line : int or None
        Where in it.
    message, hint : str
        What it is, and what to do about it.
    stays : bool
        Whether it is true until the developer acts, so that a check must fail; else it is news.
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
    """A generated file that somebody edited; `difference` is a unified diff, from what it should hold."""

    path: str
    message: str
    difference: str
