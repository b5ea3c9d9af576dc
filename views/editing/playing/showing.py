"""Describes a token game for pages: the net's places and transitions on the model, by handle."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from dineros.analysis.model.origins import Origins
from dineros.analysis.model.subject import Subject
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.editing import Document
from dineros.views.editing.playing.game import Game

MOST_LISTED = 200
"""Number of steps around the current one that pages get."""


class Stage:
    """Maps the elements of a net to the model.

    Attributes
    ----------
    signals : frozenset of int
        Transitions that change a signal.
    """

    def __init__(self, document: Document, subject: Subject) -> None:
        self._document, self._subject = document, subject
        self._origins = Origins(subject)
        names = enumerate(subject.net.transitions)
        self.signals = frozenset(index for index, name in names if self._origins.kind(name) == "signal")

    def show(self, game: Game) -> dict[str, Any]:
        """Return the current state of a game.

        Returns
        -------
        dict
            ``at``, ``length``, ``loop``, ``title``; ``places``: tokens by handle; ``queues``: by handle of
            their channel, each with its ``text``, how many messages wait (``load``) and how many more can
            (``room``); ``under``: tokens in the channels around them; ``signals``: values by handle;
            ``firings``: what is enabled, each with its ``id``, ``text``, ``kind`` and the ``elements`` it is
            seen at, and, of a change of a signal with values, its new ``value``; ``steps``: those around the
            present one, from number ``first`` on.
        """
        first = max(0, game.at - MOST_LISTED // 2)
        return {
            "at": game.at,
            "length": len(game.steps),
            "loop": game.loop,
            "title": game.title,
            **self._tokens(game.marking),
            "queues": self._queues(game.marking),
            "firings": [self._firing(transition) for transition in game.enabled()],
            "first": first,
            "steps": [self._firing(transition) for transition in game.steps[first : first + MOST_LISTED]],
        }

    def _tokens(self, marking: Sequence[int]) -> dict[str, Any]:
        net, origins = self._subject.net, self._origins
        places: dict[str, int] = defaultdict(int)
        signals: dict[str, SignalSetting] = {}
        under: dict[str, list[dict[str, Any]]] = defaultdict(list)
        for index, (name, initial) in enumerate(zip(net.places, net.initial.tolist(), strict=True)):
            tokens = marking[index]
            if name in origins.places:
                for handle in self._handles(origins.places[name]):
                    places[handle] += tokens
            elif tokens and name in origins.values:
                signal, value = origins.values[name]
                signals.update(dict.fromkeys(self._handles(signal), value))
            # Initial tokens are available resources: idle servers, clients that are ready.
            elif tokens and not initial and name in origins.channels:
                for handle in self._handles(origins.channels[name]):
                    under[handle].append({"text": self._subject.place_text(index), "tokens": tokens})
        return {"places": places, "signals": signals, "under": under}

    def _queues(self, marking: Sequence[int]) -> dict[str, list[dict[str, Any]]]:
        found: dict[str, list[dict[str, Any]]] = defaultdict(list)
        index = self._subject.place_index
        for queue in self._origins.queues:
            load, room = (marking[index[name]] for name in (queue.load, queue.capacity))
            end = f"{queue.kind} {queue.elements[1]}" if queue.kind != "request" else "requests"
            for handle in self._handles(queue.channel):
                found[handle].append({"text": end, "load": load, "room": room})
        return found

    def _firing(self, transition: int) -> dict[str, Any]:
        name = self._subject.net.transitions[transition]
        value = self._origins.setting(name)
        return {
            "id": name,
            "text": self._subject.transition_text(transition),
            "kind": self._origins.kind(name),
            "elements": self._handles(*self._origins.transitions.get(name, ())),
            **({"value": value} if isinstance(value, str) else {}),
        }

    def _handles(self, *some: EObject) -> list[str]:
        handles = map(self._document.handles.of, some)
        return [handle for handle in handles if handle is not None]
