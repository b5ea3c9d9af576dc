"""Queries about callback pages: the begin and end of callbacks, their waits, and callback groups."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    begins_answer,
    begins_callback,
    callback_page_of,
    group_or_node,
    holds_thread,
    is_awaited,
    is_goal_awaited,
    members_of,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.calls import answers
from dineros.transformations.language import TRUTH, WHOLE, Query


class Callback(Query):
    """The callback page of a place; absent if the place is on none."""

    eclass = sym.CallbackPage
    _words = "callback around {}"
    _answer = staticmethod(callback_page_of)


class Beginnings(Query):
    """The transitions with which a timer callback begins; other callbacks begin by taking a message."""

    eclass = pn.Transition
    many = True
    _words = "what begins {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> list[pn.Transition]:
        return Body(page).beginnings() if page.kind == sym.CallbackKind.timer else []


class Ends(Query):
    """The transitions with which a callback ends; those of servers and goals end with their responses."""

    eclass = pn.Transition
    many = True
    _words = "what ends {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> list[pn.Transition]:
        return [] if page.kind == sym.CallbackKind.server or works_on_goals(page) else Body(page).ends()


class LastSteps(Query):
    """The transitions with which the work of a server ends, if it proceeds step by step; empty for others."""

    eclass = pn.Transition
    many = True
    _words = "what the work of {} ends with"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> list[pn.Transition]:
        body = Body(page)
        return body.ends() if page.kind == sym.CallbackKind.server and body.is_sequential else []


class Steps(Query):
    """The transitions of a callback that executes a goal and awaits at each step; empty for others."""

    eclass = pn.Transition
    many = True
    _words = "steps of {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> list[pn.Transition]:
        return [] if holds_thread(page) else Body(page).transitions


class Group(Query):
    """The callback group of a callback or client; its node net if it names none."""

    eclass = EObject
    _words = "group of {}"
    _answer = staticmethod(group_or_node)


class Members(Query):
    """The callbacks and clients in a callback group, or in the default group of a node net."""

    eclass = EObject
    many = True
    _words = "members of {}"
    _answer = staticmethod(members_of)


class Threads(Query):
    """Number of threads of a node net's executor."""

    datatype = WHOLE
    _words = "threads of {}"
    _answer = staticmethod(threads_of)


class HoldsThread(Query):
    """Whether a callback holds a thread while it runs."""

    datatype = TRUTH
    _words = "{} holds a thread"
    _answer = staticmethod(holds_thread)


class BeginsCallback(Query):
    """Whether responses to a client begin a separate callback."""

    datatype = TRUTH
    _words = "response to {} begins a callback"
    _answer = staticmethod(begins_callback)


class Awaited(Query):
    """Whether a client's callback releases its thread while it waits for the response."""

    datatype = TRUTH
    _words = "response to {} is awaited"
    _answer = staticmethod(is_awaited)


class GoalAwaited(Query):
    """Whether the callback that sends a client's goals releases its thread until they end."""

    datatype = TRUTH
    _words = "goals of {} are awaited"
    _answer = staticmethod(is_goal_awaited)


def _told(client: sym.ActionClientPort, move: pn.Transition) -> pn.Place | None:
    places = {*answers(client), client.accepted, client.feedback}
    told = (arc.target for arc in move.outgoing)
    return next((place for place in told if isinstance(place, pn.Place) and place in places), None)


class Told(Query):
    """The place onto which a transition puts an action client's answer, acceptance or feedback, if any."""

    eclass = pn.Place
    _words = "where {1} tells {0}"
    _answer = staticmethod(_told)


class BeginsAnswer(Query):
    """Whether the message that a transition gives to an action client begins a separate callback."""

    datatype = TRUTH
    _words = f"{Told._words} begins a callback"

    @staticmethod
    def _answer(client: sym.ActionClientPort, move: pn.Transition) -> bool:
        return begins_answer(client, _told(client, move))


class GoesOn(Query):
    """Whether a callback that awaits continues with the message: an answer on its own page."""

    datatype = TRUTH
    _words = f"{{0}} awaits {Told._words}"

    @staticmethod
    def _answer(client: sym.ActionClientPort, move: pn.Transition) -> bool:
        place = _told(client, move)
        if place not in answers(client) or not is_goal_awaited(client):
            return False
        return callback_page_of(place) is callback_page_of(client.goal)
