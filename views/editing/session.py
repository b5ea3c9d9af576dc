"""The messages between pages and a document, as JSON texts; without any network.

A page first gets a snapshot, and then a message for every change by any page.
Each request has a number; the answer is that it is done, or refused and why.
"""

from __future__ import annotations

import json
import logging
import time
from dataclasses import dataclass, field
from typing import Any

from dineros.metamodel import sym
from dineros.metamodel.clauses import signals_of_clause
from dineros.metamodel.editing import CommandError, Document, Done, decode_commands
from dineros.metamodel.editing.composed import compose, decode_operation
from dineros.metamodel.errors import ClauseError, DinerosError, without_middle
from dineros.metamodel.json_text import decode_json
from dineros.views.editing.contents import changed_json, marks_json, model_json
from dineros.views.editing.description import description_for
from dineros.views.editing.playing import PlayingDesk
from dineros.views.editing.working import Jobs

LOG = logging.getLogger("dineros.views.editing")

LONGEST_MESSAGE = 1 << 20
"""Limit of the bytes of a message from a page."""

QUICK = 0.1
"""Seconds of processor time that a check after every change may take; slower ones wait for a pause."""

_FIELDS = {
    "do": {"commands", "label", "epoch"},
    "compose": {"operation", "label", "epoch"},
    "clause": {"element", "text", "epoch"},
    "undo": {"epoch"},
    "redo": {"epoch"},
    "save": {"over"},
    "reload": set(),
    "play": set(PlayingDesk.fields) | {"job", "witness"},
    "work": {"action", "order", "job"},
}
"""Requests of pages, with their arguments."""


@dataclass
class Answer:
    """The replies to a message from a page.

    Attributes
    ----------
    own : list of str
        Messages for this page.
    all : list of str
        Messages for all pages, this one included, before its own.
    """

    own: list[str] = field(default_factory=list)
    all: list[str] = field(default_factory=list)


class Session:
    """One document and all its pages."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.playing = PlayingDesk(document)
        self.jobs: Jobs | None = None
        self.checking_took = 0.0
        self._marks_of: tuple[str, int] | None = None
        self._marks: dict[str, Any] = {}
        self._file: dict[str, Any] = {}

    def greeting(self) -> str:
        """Return the complete state, for a page that has just been opened."""
        document = self.document
        said = {
            "type": "snapshot",
            "epoch": document.epoch,
            "revision": document.revision,
            "metamodel": description_for(document.root),
            "model": model_json(document),
            "marks": self.check(),
            "state": self._state(),
            "recovered": document.recovered,
            "jobs": self.jobs.known() if self.jobs is not None else [],
        }
        return _text(said)

    def check(self) -> dict[str, Any]:
        """Return the marks of the current model."""
        now = (self.document.epoch, self.document.revision)
        if self._marks_of != now:
            begun = time.thread_time()
            self._marks = marks_json(self.document, self.document.violations())
            self.checking_took = time.thread_time() - begun
            self._marks_of = now
        return self._marks

    def new_marks(self) -> str | None:
        """Return a message with the marks, if the last ones belong to an earlier state."""
        if self._marks_of == (self.document.epoch, self.document.revision):
            return None
        return _text({"type": "marks", "revision": self.document.revision, "marks": self.check()})

    def looked_at_file(self) -> str | None:
        """Return a message if the state of the file differs from the one that pages know."""
        known = self._file
        state = self._state()
        return _text({"type": "state", "state": state}) if state != known else None

    def _state(self) -> dict[str, Any]:
        document = self.document
        self._file = {
            "file": document.path.name,
            "disk": document.disk(),
            "saved": document.is_saved,
            "undo": document.undo_label,
            "redo": document.redo_label,
        }
        return self._file

    def hear(self, text: str | bytes, page: str) -> Answer:
        """Carry out the request of a page, if possible.

        Parameters
        ----------
        text : str or bytes
            The message of the page.
        page : str
            The id of the page while it is open.
        """
        number: int | None = None
        try:
            said = decode_json(text, limit=LONGEST_MESSAGE)
            if not isinstance(said, dict):
                raise CommandError("a message must be an object")
            number = _number(said.get("number"))
            return self._answer(said, number, page)
        except DinerosError as error:
            return Answer(own=[_refusal(number, error)])
        except Exception as error:  # a mistake of ours must not end the page, nor pass unseen
            found = DinerosError(f"unexpected {type(error).__name__}: {error}", hint="please report it")
            LOG.error("a command failed: %s", found)
            LOG.debug("where it failed", exc_info=True)
            return Answer(own=[_refusal(number, found)])

    def _answer(self, said: dict[str, Any], number: int, page: str) -> Answer:
        ask = said.get("ask")
        fields = _FIELDS.get(ask) if isinstance(ask, str) else None
        if fields is None:
            raise CommandError(f"a request must be one of {', '.join(_FIELDS)}")
        for name in said:
            if name not in fields | {"ask", "number"}:
                raise CommandError(f"{ask} has no field {name[:100]!r}")
        document, by = self.document, (page, number)
        if ask == "play":
            return Answer([_done(number, self._play(said, page))])
        if ask == "work":
            return Answer([_done(number, self._work(said))])
        if said.get("epoch", document.epoch) != document.epoch:
            raise CommandError(
                "the model was reloaded in the meantime", hint="check the model, then repeat the change"
            )
        if ask in ("do", "compose"):
            label = said.get("label", "")
            if not isinstance(label, str):
                raise CommandError("label must be a string")
            return self._told(self._do(said, label, by), by)
        if ask == "clause":
            self._try_clause(said.get("element"), said.get("text"))
            return Answer([_done(number, {})])
        if ask in ("undo", "redo"):
            return self._told(document.undo(by) if ask == "undo" else document.redo(by), by)
        if ask == "save":
            over = said.get("over", False)
            if not isinstance(over, bool):
                raise CommandError("over must be true or false")
            epoch = document.epoch
            content = document.save(over=over)
            everybody = self._told_file() if document.epoch == epoch else [self.greeting()]
            return Answer([_done(number, {"keepsForm": content.keeps_form})], everybody)
        document.reload()
        return Answer([_done(number, {})], [self.greeting()])

    def _do(self, said: dict[str, Any], label: str, by: tuple[str, int]) -> Done:
        document = self.document
        if said["ask"] == "do":
            return document.do(decode_commands(said.get("commands")), label, by)
        operation = decode_operation(said.get("operation"))
        # A request repeated after a loss may name elements that no longer exist.
        return document.done_before(by) or document.do(
            compose(document.root, document.handles, operation), label, by
        )

    def _try_clause(self, handle: object, text: object) -> None:
        """Check a clause for a transition without changing the model."""
        if not isinstance(handle, str) or not isinstance(text, str):
            raise CommandError("element and text must be strings")
        transition = self.document.handles.find(handle)
        if not isinstance(transition, sym.Transition):
            raise CommandError("only transitions have clauses")
        if text.strip():
            signals_of_clause(transition, text)

    def _play(self, said: dict[str, Any], page: str) -> dict[str, Any]:
        """Carry out a request for a token game, including one for the traces of a job."""
        if "job" in said:
            job, witness = said.pop("job"), said.pop("witness", None)
            if self.jobs is None or type(job) is not int or not (witness is None or type(witness) is int):
                raise CommandError("job and witness must be numbers")
            said["traces"] = self.jobs.traces(job, witness)
        return self.playing.hear(said, page)

    def _work(self, said: dict[str, Any]) -> dict[str, Any]:
        action, order, job = said.get("action"), said.get("order"), said.get("job")
        if self.jobs is None:
            raise CommandError("this editor cannot run commands")
        if action == "start" and isinstance(order, dict):
            return {"job": self.jobs.start(order)}
        if action == "cancel" and type(job) is int:
            self.jobs.cancel(job)
            return {}
        raise CommandError("give an order to start a job, or the number of a job to cancel it")

    def _told(self, done: Done, by: tuple[str, int]) -> Answer:
        own = [_done(by[1], {"revision": done.revision, "made": done.made})]
        if not done.touched:
            return Answer(own)
        change = {
            "type": "change",
            "epoch": self.document.epoch,
            "revision": done.revision,
            "objects": changed_json(self.document, done.touched),
            "state": self._state(),
            "by": list(by),
        }
        answer = Answer(own, [_text(change)])
        if self.checking_took <= QUICK and (marks := self.new_marks()) is not None:
            answer.all.append(marks)
        return answer

    def _told_file(self) -> list[str]:
        return [_text({"type": "state", "state": self._state()})]


def _number(found: object) -> int:
    if isinstance(found, bool) or not isinstance(found, int) or not 0 < found < 2**53:
        raise CommandError("a message must have a number of 1 or more")
    return found


def _done(number: int, more: dict[str, Any]) -> str:
    return _text({"type": "done", "number": number, **more})


def _refusal(number: int | None, error: DinerosError) -> str:
    said: dict[str, Any] = {"type": "refused", "number": number, "reason": without_middle(error.message)}
    if error.hint:
        said["hint"] = without_middle(error.hint)
    if isinstance(error, ClauseError) and error.column is not None:
        said["column"] = error.column
    return _text(said)


def job_text(job: dict[str, Any]) -> str:
    """Return the message about a job."""
    return _text({"type": "job", **job})


def _text(said: dict[str, Any]) -> str:
    return json.dumps(said, ensure_ascii=False, separators=(",", ":"))
