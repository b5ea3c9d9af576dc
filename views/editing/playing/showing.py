"""A token game as pages get it: what the net's places and transitions are on the model, by handle."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from dineros.analysis.model.queues import Queue, queues
from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.editing import Document
from dineros.metamodel.elements import elements
from dineros.metamodel.records import Drop, Fire, Signal
from dineros.transformations.flattening.traces import Link
from dineros.views.editing.playing.game import Game

MOST_LISTED = 200
"""Steps around the present one that pages get."""


class Stage:
    """Where on the model a net is played.

    Parameters
    ----------
    document : Document
        The model.
    subject : Subject
        The net that was made from it.

    Attributes
    ----------
    signals : frozenset of int
        Transitions that change a signal.
    """

    def __init__(self, document: Document, subject: Subject) -> None:
        self._document, self._subject = document, subject
        self._roles: dict[str, StepRole] = step_roles(subject.links())
        self._queues: list[Queue] = queues(subject)
        if subject.flattened is None:
            own = {each.id: document.handles.of(each) for each in elements(document.root)}
            self._places = {name: own.get(name) for name in subject.net.places}
            self._elements = {name: [own.get(name)] for name in subject.net.transitions}
            self._values: dict[str, tuple[str | None, bool]] = {}
            self._channels: dict[str, str | None] = {}
        else:
            self._read_links()
        self.signals = frozenset(
            number for number, name in enumerate(subject.net.transitions) if self._kind(name) == "signal"
        )

    def _read_links(self) -> None:
        self._places, self._elements, self._values, self._channels = {}, {}, {}, {}
        copies = {
            str(link.target.id): link.sources[0]
            for link in self._subject.links()
            if isinstance(link.target, pn.Place) and _is_own(link)
        }
        hidden = {name for queue in self._queues for name in (queue.load, queue.capacity)}
        for link in self._subject.links():
            name = str(link.target.id)
            if isinstance(link.target, pn.Transition):
                self._elements[name] = self._where(link, copies)
            elif name in copies:
                self._places[name] = self._handle(copies[name])
            elif link.meaning is not None and link.meaning.value is not None:
                self._values[name] = self._handle(link.sources[0]), link.meaning.value
            elif name not in hidden and isinstance(link.target, pn.Place):
                channel = next((each for each in link.sources if isinstance(each, sym.Channel)), None)
                if channel is not None:
                    self._channels[name] = self._handle(channel)

    def _where(self, link: Link, copies: dict[str, EObject]) -> list[str | None]:
        """Return where on the model a transition is seen: what it was made for, and the place of its port."""
        role = self._roles[str(link.target.id)]
        found: list[EObject] = [each for each in link.sources if isinstance(each, (pn.Node, sym.Channel))]
        found = found[:1] or [each for each in link.sources if isinstance(each, pn.Element)][:1]
        if role.kind is Signal:
            found = [each for each in link.sources if isinstance(each, sym.InputSignal)]
        if role.place in copies:
            found.append(copies[role.place])
        return list(dict.fromkeys(self._handle(each) for each in found))

    def _handle(self, element: EObject) -> str | None:
        return self._document.handles.of(element)

    def _kind(self, name: str) -> str:
        role = self._roles.get(name)
        if role is None or role.kind is Fire:
            return "fire"
        return {Signal: "signal", Drop: "loss"}.get(role.kind, "channel")

    def show(self, game: Game) -> dict[str, Any]:
        """Return a game as it stands.

        Returns
        -------
        dict
            ``at``, ``length``, ``loop``, ``title``; ``places``: tokens by handle; ``queues``: by the handle of
            their channel, each with its ``text``, how many messages wait (``load``) and how many more can
            (``room``); ``under``: tokens in channels beside them; ``signals``: values by handle; ``firings``: what
            is enabled, each with its ``id``, ``text``, ``kind`` and the ``elements`` it is seen at; ``steps``:
            those around the present one, from number ``first`` on.
        """
        subject, marking = self._subject, game.marking
        places: dict[str, int] = defaultdict(int)
        signals: dict[str, bool] = {}
        under: dict[str, list[dict[str, Any]]] = defaultdict(list)
        starts = subject.net.initial.tolist()
        for name, tokens, initial in zip(subject.net.places, marking, starts, strict=True):
            if (handle := self._places.get(name)) is not None:
                places[handle] += tokens
            elif name in self._values and tokens:
                signal, value = self._values[name]
                if signal is not None:
                    signals[signal] = value
            # What is there from the beginning is free for use: idle servers, clients that are ready.
            elif tokens and not initial and (channel := self._channels.get(name)) is not None:
                text = subject.place_text(subject.place_index[name])
                under[channel].append({"text": text, "tokens": tokens})
        first = max(0, game.at - MOST_LISTED // 2)
        return {
            "at": game.at,
            "length": len(game.steps),
            "loop": game.loop,
            "title": game.title,
            "places": places,
            "queues": self._queues_now(marking),
            "under": under,
            "signals": signals,
            "firings": [self._firing(transition) for transition in game.enabled()],
            "first": first,
            "steps": [self._firing(transition) for transition in game.steps[first : first + MOST_LISTED]],
        }

    def _queues_now(self, marking: list[int]) -> dict[str, list[dict[str, Any]]]:
        found: dict[str, list[dict[str, Any]]] = defaultdict(list)
        index = self._subject.place_index
        for queue in self._queues:
            handle = self._handle(queue.channel)
            if handle is not None:
                load, room = (marking[index[name]] for name in (queue.load, queue.capacity))
                end = f"{queue.kind} {queue.elements[1]}" if queue.kind != "request" else "requests"
                found[handle].append({"text": end, "load": load, "room": room})
        return found

    def _firing(self, transition: int) -> dict[str, Any]:
        name = self._subject.net.transitions[transition]
        seen = [handle for handle in self._elements.get(name, ()) if handle is not None]
        text = self._subject.transition_text(transition)
        return {"id": name, "text": text, "kind": self._kind(name), "elements": seen}


def _is_own(link: Link) -> bool:
    """Whether a place of the net is one of the model, or a copy of it."""
    return link.meaning is None and link.role == "place" and isinstance(link.sources[0], pn.Place)
