"""Handles requests for token games: one for each page, on the model at the start of the game."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Any

from dineros.analysis.model.subject import subject_for
from dineros.metamodel.editing import CommandError, Document
from dineros.metamodel.errors import counted
from dineros.views.editing.playing.game import Game
from dineros.views.editing.playing.showing import Stage
from dineros.views.editing.playing.traces import game_of, text_of

MOST_GAMES = 16
"""Limit of the games; the least recently used one is discarded."""

MOST_AT_ONCE = 1_000
"""Limit of the random steps of one request."""

_FIELDS: dict[str, dict[str, type | tuple[type, ...]]] = {
    "begin": {"signals": str},
    "open": {"traces": dict},
    "fire": {"transition": str, "at": int},
    "go": {"to": int},
    "wander": {"count": int, "at": int},
    "end": {},
}
"""Actions of pages in a game, with their arguments."""


@dataclass
class _Table:
    """A game, with the state of the model to which it belongs."""

    game: Game
    stage: Stage
    state: tuple[str, int]


class PlayingDesk:
    """The games of all pages.

    Parameters
    ----------
    document : Document
        The model.
    draw : Random, optional
        The generator for random steps.
    """

    fields = frozenset({"action", *(name for fields in _FIELDS.values() for name in fields)})

    def __init__(self, document: Document, draw: Random | None = None) -> None:
        self._document = document
        self._draw = draw or Random()
        self._tables: dict[str, _Table] = {}

    def hear(self, said: dict[str, Any], page: str) -> dict[str, Any]:
        """Carry out the request of a page; return the resulting game.

        The request has the position that the page knows, so that a repeated request is carried out once.

        Raises
        ------
        DinerosError
            It is not possible; the game does not change.
        """
        action = said.get("action")
        fields = _FIELDS.get(action) if isinstance(action, str) else None
        if action is None or fields is None:
            raise CommandError(f"an action of a game must be one of {', '.join(_FIELDS)}")
        for name, kind in fields.items():
            if not isinstance(said.get(name), kind) or isinstance(said.get(name), bool):
                raise CommandError(f"{action} needs {name}")
        for name in self.fields - {"action", *fields}:
            if name in said:
                raise CommandError(f"{action} has no field {name!r}")
        if action == "end":
            self._tables.pop(page, None)
            return {}
        if action in ("begin", "open"):
            table = self._begun(said)
            self._tables.pop(page, None)
            self._tables[page] = table
            if len(self._tables) > MOST_GAMES:
                del self._tables[next(iter(self._tables))]
        else:
            table = self._table(page)
            self._step(table, str(action), said)
        return {"game": {"epoch": table.state[0], "revision": table.state[1], **table.stage.show(table.game)}}

    def trace(self, page: str) -> str:
        """Return the game of a page up to its current position as a trace.

        Raises
        ------
        CommandError
            There is no game, or it is of an earlier model.
        """
        return text_of(self._table(page).game, str(self._document.path))

    def _begun(self, said: dict[str, Any]) -> _Table:
        document = self._document
        errors = sum(each.severity == "error" for each in document.violations())
        if errors:
            raise CommandError(
                f"the model has {counted(errors, 'error')}", hint="correct them first: see problems"
            )
        if said["action"] == "begin":
            game = Game(subject_for(document.root, said["signals"], "weighted"))
        else:
            texts = said["traces"]
            if not texts or not all(isinstance(each, str) for each in texts.values()):
                raise CommandError("traces must be an object of strings, by their names")
            game = game_of(document.root, texts)
        return _Table(game, Stage(document, game.subject), (document.epoch, document.revision))

    def _table(self, page: str) -> _Table:
        table = self._tables.get(page)
        if table is None:
            raise CommandError("no game has been started")
        if table.state != (self._document.epoch, self._document.revision):
            raise CommandError("the model has changed since the game started", hint="begin another one")
        return table

    def _step(self, table: _Table, action: str, said: dict[str, Any]) -> None:
        game = table.game
        if action == "go":
            game.go(said["to"])
        elif game.at != said["at"]:
            pass  # done already, or asked of a position that is no longer shown
        elif action == "wander":
            if not 0 < said["count"] <= MOST_AT_ONCE:
                raise CommandError(f"the number of random steps must be 1 to {MOST_AT_ONCE:,}")
            game.wander(said["count"], self._draw, table.stage.signals)
        else:
            transition = game.subject.transition_index.get(said["transition"])
            if transition is None:
                raise CommandError(f"the net has no transition {said['transition'][:100]!r}")
            game.fire(transition)
