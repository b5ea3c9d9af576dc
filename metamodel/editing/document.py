"""A model file that is being edited: commands, undo and redo, its journal, saving, external changes."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints import Violation, validate
from dineros.metamodel.editing.changes import Change, redo, touched, undo
from dineros.metamodel.editing.commands import Command, CommandError, decode_commands, encode_command
from dineros.metamodel.editing.editor import Editor, Performed
from dineros.metamodel.editing.handles import Handles
from dineros.metamodel.editing.journal import Journal, JournalError, digest, journal_of
from dineros.metamodel.editing.storing import SUFFIXES, Content, Form, new_net, read_content
from dineros.metamodel.errors import DinerosError, Location, ModelFileError, near_matches
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.positions import remember_file

LARGE_JOURNAL = 16 * 1024 * 1024
"""Size of a journal above which it restarts when the model is saved; earlier steps cannot be undone then."""

MOST_SENDERS = 64
"""Number of senders whose last group number is stored."""

Disk: TypeAlias = Literal["same", "changed", "gone", "new"]
"""External changes of the file since it was read or saved; ``new``: there was no file."""

By: TypeAlias = tuple[str, int]
"""Sender of a group of commands, and its number for the sender: a repeated group is executed once."""


@dataclass(frozen=True)
class Done:
    """The result of a group of commands.

    Attributes
    ----------
    revision : int
        Number of the resulting state of the model.
    touched : list of EObject
        Objects whose appearance has changed; some may be deleted.
    made : dict of str
        Handles of the objects made, by their names in the commands.
    """

    revision: int
    touched: list[EObject]
    made: dict[str, str]


@dataclass(frozen=True)
class _Group:
    label: str
    changes: list[Change]


class Document:
    """A model file that is being edited, by one process only.

    Parameters
    ----------
    path : Path
        The file; if it does not exist, a new system model is started.

    Attributes
    ----------
    path : Path
        The file.
    epoch : str
        Identifies the content of the file for which handles are numbered: in another epoch, handles refer to
        other elements. It is restored after a process was killed.
    revision : int
        Number of the current state of the model.
    recovered : int
        Number of groups recovered from the journal of a killed process.

    Raises
    ------
    ModelFileError
        The file cannot be read, or its format cannot be edited.
    JournalError
        Another process edits the file, or its journal cannot be read.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() not in SUFFIXES:
            raise ModelFileError(
                f"{path.suffix!r} is not a suffix of a model that can be edited",
                location=Location(path),
                hint=near_matches(path.suffix, SUFFIXES) or f"dineros convert makes {', '.join(SUFFIXES)}",
            )
        self.path = path
        content = self._read()
        if content is not None:
            read_content(content, path)  # so that a file that is not a model gets no journal
        self._journal = Journal(journal_of(path))
        try:
            if self._journal.entries:
                self._recover(content)
            else:
                self._begin(content)
                self._journal.begin(content)
        except BaseException:
            self._journal.close(remove=not self._journal.entries)
            raise

    def _begin(self, content: bytes | None) -> None:
        net = new_net(self.path) if content is None else read_content(content, self.path)
        remember_file(net, self.path)
        self.epoch = (digest(content) or "new")[:16]
        self.revision = 0
        self.recovered = 0
        self._editor = Editor(net)
        self._form = Form(self.path, content, net)
        self._undo: list[_Group] = []
        self._redo: list[_Group] = []
        self._saved: _Group | None = None
        self._known = digest(content)
        self._seen: tuple[tuple[int, ...], str | None] | None = None
        self._last: dict[str, tuple[int, Done]] = {}

    def _recover(self, content: bytes | None) -> None:
        """Repeat the steps in the journal."""
        self._begin(self._journal.base())
        for number, entry in enumerate(self._journal.entries[1:], 2):
            try:
                self._replay(entry)
            except DinerosError as error:
                raise JournalError(
                    f"holds a change that cannot be repeated: {error.message}",
                    location=Location(self._journal.path, number),
                    hint="move it away to continue without its changes",
                ) from error
        if digest(content) != self._known and content is not None:
            # The process was killed between writing the file and recording that.
            try:
                is_ours = content == self._form.content(self.root).data
            except DinerosError:
                is_ours = False
            if is_ours:
                self._note_saved(content)

    def _replay(self, entry: Mapping[str, Any]) -> None:
        by = _sender(entry.get("by"))
        if "do" in entry:
            commands = decode_commands(entry["do"])
            self._finish(self._editor.perform(commands), str(entry.get("label", "")), by)
            self.recovered += 1
        elif entry.get("undo") or entry.get("redo"):
            self._turn(bool(entry.get("undo")), by, noted=True)
            self.recovered += 1
        elif isinstance(entry.get("saved"), str):
            self._mark_saved(entry["saved"])
        else:
            raise CommandError("an entry of unknown kind")

    # ------------------------------------------------------------------------------------ looking

    @property
    def root(self) -> pn.Net:
        """The model; only commands may change it."""
        return self._editor.root

    @property
    def handles(self) -> Handles:
        """The handles of its objects."""
        return self._editor.handles

    @property
    def undo_label(self) -> str | None:
        """Label of the group that would be undone; None: there is none."""
        return self._undo[-1].label if self._undo else None

    @property
    def redo_label(self) -> str | None:
        """Label of the group that would be redone; None: there is none."""
        return self._redo[-1].label if self._redo else None

    @property
    def is_saved(self) -> bool:
        """Whether the file has the current state of the model."""
        at = self._undo[-1] if self._undo else None
        return at is self._saved and self._known is not None

    def violations(self) -> list[Violation]:
        """Check the model against all constraints."""
        return validate(self.root)

    def content(self) -> Content:
        """Return the content that saving would write now.

        Raises
        ------
        ModelFileError
            The format cannot represent the model.
        """
        return self._form.content(self.root)

    def _read(self) -> bytes | None:
        is_there = self.path.exists() or self.path.is_symlink()  # a link to nothing, or to itself
        return read_bytes(self.path) if is_there else None

    def disk(self) -> Disk:
        """Return the external changes of the file since it was read or saved."""
        try:
            now = self._digest_now()
        except DinerosError:
            return "changed"
        if now == self._known:
            return "same" if now is not None else "new"
        return "gone" if now is None else "changed"

    def _digest_now(self) -> str | None:
        """Return the digest of the file; it is read only if it may have changed since the last time."""
        try:
            status = self.path.stat()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise ModelFileError(f"cannot be read: {error.strerror}", location=Location(self.path)) from error
        signature = (status.st_ino, status.st_mtime_ns, status.st_ctime_ns, status.st_size)
        # A file that was just written may be changed again within the resolution of its time stamp.
        if self._seen is None or self._seen[0] != signature or time.time_ns() - status.st_mtime_ns < 10**9:
            self._seen = signature, digest(read_bytes(self.path))
        return self._seen[1]

    def on_disk(self) -> pn.Net:
        """Return the model that the file contains now, for a comparison.

        Raises
        ------
        ModelFileError
            It contains no model.
        """
        return read_content(read_bytes(self.path), self.path)

    # ------------------------------------------------------------------------------------ changing

    def do(self, commands: Sequence[Command], label: str = "", by: By | None = None) -> Done:
        """Execute a group of commands; it is in the journal when this returns.

        Parameters
        ----------
        commands : sequence of Command
            The commands, executed completely or not at all.
        label : str
            Description of the group, for undo.
        by : tuple of str and int, optional
            The sender, and the number of its group; a repeated group is not executed again.

        Raises
        ------
        CommandError, ClauseError
            It cannot be executed; nothing has changed.
        JournalError
            The journal cannot be written; nothing has changed.
        """
        if (done := self.done_before(by)) is not None:
            return done
        count = len(self.handles)
        performed = self._editor.perform(commands)
        if not performed.changes:  # the model has these values already
            return Done(self.revision, [], performed.made)
        entry = {"do": [encode_command(each) for each in commands], "label": label[:200]}
        try:
            self._journal.append(_signed(entry, by))
        except BaseException:
            undo(performed.changes)
            self.handles.forget_from(count)
            raise
        return self._finish(performed, label[:200], by)

    def _finish(self, performed: Performed, label: str, by: By | None) -> Done:
        self._undo.append(_Group(label, performed.changes))
        self._redo.clear()
        return self._answer(performed.changes, performed.made, by)

    def undo(self, by: By | None = None) -> Done:
        """Undo the last group of commands.

        Raises
        ------
        CommandError
            There is none.
        JournalError
            The journal cannot be written; nothing changed.
        """
        return self.done_before(by) or self._turn(True, by)

    def redo(self, by: By | None = None) -> Done:
        """Redo the group undone last; raises like `undo`."""
        return self.done_before(by) or self._turn(False, by)

    def _turn(self, back: bool, by: By | None, *, noted: bool = False) -> Done:
        """Undo or redo a group; `noted`: it is in the journal already."""
        source, target = (self._undo, self._redo) if back else (self._redo, self._undo)
        if not source:
            what = "undo or redo" if noted else "undo" if back else "do again"
            raise CommandError(f"there is nothing to {what}")
        if not noted:
            self._journal.append(_signed({"undo" if back else "redo": True}, by))
        group = source.pop()
        (undo if back else redo)(group.changes)
        target.append(group)
        return self._answer(group.changes, {}, by)

    def _answer(self, changes: list[Change], made: dict[str, str], by: By | None) -> Done:
        self.revision += 1
        done = Done(self.revision, touched(changes), made)
        if by is not None:
            self._last.pop(by[0], None)
            self._last[by[0]] = (by[1], done)
            if len(self._last) > MOST_SENDERS:
                del self._last[next(iter(self._last))]
        return done

    def done_before(self, by: By | None) -> Done | None:
        """Return the result of a repeated group; None: the group is new.

        Raises
        ------
        CommandError
            Later groups of the sender have been executed.
        """
        if by is None or by[0] not in self._last:
            return None
        number, done = self._last[by[0]]
        if by[1] > number:
            return None
        if by[1] < number:
            raise CommandError(f"number {by[1]} came after number {number}")
        return Done(done.revision, [], done.made)

    # ------------------------------------------------------------------------------------ saving

    def save(self, *, over: bool = False) -> Content:
        """Write the model into its file, atomically.

        Parameters
        ----------
        over : bool
            Whether to overwrite external changes of the file.

        Raises
        ------
        ModelFileError
            The file has external changes, cannot be written, or its format cannot represent the model.
        """
        if not over and self.disk() == "changed":
            raise ModelFileError(
                "was changed by another program or person",
                location=Location(self.path),
                hint="compare, then choose one",
            )
        content = self.content()
        write_atomically(self.path, content.data)
        self._note_saved(content.data)
        if self._journal.size > LARGE_JOURNAL:
            self.reload()
        return content

    def _note_saved(self, content: bytes) -> None:
        self._journal.append({"saved": digest(content)})
        self._mark_saved(str(digest(content)))

    def _mark_saved(self, known: str) -> None:
        self._known = known
        self._saved = self._undo[-1] if self._undo else None

    def reload(self) -> None:
        """Restart with the content of the file; unsaved changes are lost, and nothing can be undone.

        Raises
        ------
        ModelFileError
            The file contains no model; nothing has changed.
        """
        content = read_bytes(self.path)
        read_content(content, self.path)
        self._journal.begin(content)
        self._begin(content)

    def close(self) -> None:
        """Close the document; unsaved changes stay in the journal for the next time."""
        self._journal.close(
            remove=self.is_saved or (self._known is None and not self._undo and not self._redo)
        )


def _sender(found: object) -> By | None:
    match found:
        case [str(name), int(number)]:
            return name, number
    return None


def _signed(entry: dict[str, Any], by: By | None) -> dict[str, Any]:
    return entry if by is None else {**entry, "by": list(by)}
