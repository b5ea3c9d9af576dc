"""Latencies of actions (rule D11): goals, refusals, requests to cancel, and results come within a time.

A latency and the time until a node takes the message are one interval from 0 on, which begins again if no
thread is free meanwhile. So each message may come when it comes in truth, and at other times: what is proved
holds. Goals and results of clients that do not wait count in their histories while they are on their way.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Index, Made, New, Node
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.goals import A1, A2, Heard, Taken, Wish
from dineros.transformations.rules.actions.slots import slots
from dineros.transformations.rules.notation import action_with_client, at_once
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import (
    GoalsInTime,
    HeardUntil,
    ResultsInTime,
    TakenUntil,
)
from dineros.transformations.rules.queries.times import HasInterval
from dineros.transformations.rules.requests import Entrance
from dineros.transformations.rules.services import Home


class D11Send(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A client sends a goal as soon as it can."""

    action, client = action_with_client()
    send = Made(A1.send, of=client)
    move = Node(pn.Transition, of=send)

    prompt = at_once(move)

    where = [GoalsInTime(action, Home(action.server.entry)), ~HasInterval(move)]


class D11Accept(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A server accepts a goal within its latency if a slot and a thread are free."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    accept = Made(A2.accept, of=[client, slot])
    move = Node(pn.Transition, of=accept)

    within = New(pn.TimeInterval, into=move.interval, latest=TakenUntil(action, Home(action.server.entry)))

    where = [GoalsInTime(action, Home(action.server.entry)), ~HasInterval(move)]


class D11Taken(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A server refuses a goal, or takes a request to cancel, within its latency."""

    action = Node(sym.ActionChannel)
    taken = Made(Taken, of=action)
    move = Node(pn.Transition, of=taken.move)

    within = New(pn.TimeInterval, into=move.interval, latest=TakenUntil(action, Home(action.server.entry)))

    where = [GoalsInTime(action, Home(action.server.entry)), ~HasInterval(move)]


class D11Wish(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A client sends a request to cancel as soon as it can."""

    action, client = action_with_client()
    wish = Made(Wish, of=client)
    move = Node(pn.Transition, of=wish.move)

    prompt = at_once(move)

    where = [GoalsInTime(action, Home(action.server.entry)), ~HasInterval(move)]


class D11End(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A goal ends when the transitions that work on it end it."""

    action = Node(sym.ActionChannel)
    end = Made(End, of=action)
    move = Node(pn.Transition, of=end.move)

    prompt = at_once(move)

    where = [GoalsInTime(action, Home(action.server.entry)), ~HasInterval(move)]


class D11Enter(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """Goals, answers and results enter their histories at once; the latency ends when they are taken."""

    action, client = action_with_client()
    queue = Made(Entrance, of=client)
    enter = Node(pn.Transition, of=queue.enter)
    drop = Node(pn.Transition, of=queue.drop)

    enters = at_once(enter)
    drops = at_once(drop)

    where = [GoalsInTime(action, Home(action.server.entry)), ResultsInTime(client, Home(action.server.entry))]


class D11Heard(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A client takes a message of an action within its latency if a thread is free."""

    action, client = action_with_client()
    heard = Made(Heard, of=client)
    move = Node(pn.Transition, of=heard.move)

    within = New(pn.TimeInterval, into=move.interval, latest=HeardUntil(client, Home(action.server.entry)))

    where = [ResultsInTime(client, Home(action.server.entry)), ~HasInterval(move)]
