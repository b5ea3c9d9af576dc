"""Durations, offsets, jitter, reactions and orders: where they have no effect, and which are impossible.

That an interval is not upside down, and has finite bounds from 0, is asked of every interval in `nets`.
"""

from __future__ import annotations

import math

from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.files.exact import fraction_of


@constraint(
    "{it} has a duration, but {found}",
    fix="set the execution of its node net to callbacks, or give the duration to its transitions",
    severity="warning",
    guard=lambda page, index: page.duration is not None,
)
def callback_duration_usable(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback page with a duration belongs to a node net that runs callbacks."""
    node_net = index.node_net_of(page)
    if node_net is None:
        return "belongs to no node net"
    return runs_callbacks(node_net) or "its node net does not run callbacks"


@constraint(
    "{it} has a duration, but {found}",
    fix="give the duration to its callback page, or an interval to the transition",
    severity="warning",
    guard=lambda transition, index: transition.duration is not None,
)
def handler_duration_usable(transition: sym.Transition, index: Index) -> Outcome:
    """A transition with a duration belongs to a node net of the execution net: its handler is in flight."""
    node_net = index.node_net_of(transition)
    if node_net is None:
        return "belongs to no node net"
    return not runs_callbacks(node_net) or "its node net runs callbacks, which have durations of their own"


@constraint(
    "{it} has {found}, but is not called by a timer",
    fix="remove it, or set its kind to timer",
    severity="warning",
    guard=lambda page, index: page.offset is not None or page.jitter is not None,
)
def strikes_of_timers(page: sym.CallbackPage, index: Index) -> Outcome:
    """Only the callback page of a timer has an offset or a jitter."""
    given = [name for name in ("offset", "jitter") if getattr(page, name) is not None]
    return page.kind == sym.CallbackKind.timer or f"an {' and a '.join(given)}".replace(
        "an jitter", "a jitter"
    )


@constraint(
    "{it} has the jitter {element.jitter}{found}",
    fix="set the jitter to 0 or more, and to less than the period",
    guard=lambda page, index: page.jitter is not None,
)
def jitter_within_period(page: sym.CallbackPage, index: Index) -> Outcome:
    """The jitter of a timer is a finite number from 0, and not longer than its period."""
    assert page.jitter is not None
    if not math.isfinite(page.jitter) or page.jitter < 0:
        return ", which is not a time"
    if page.timer is None or not math.isfinite(page.timer):
        return True
    return fraction_of(page.jitter) <= fraction_of(page.timer) or f", longer than its period {page.timer}"


@constraint(
    "{it} has a reaction, but runs callbacks",
    fix="give durations to its callback pages, or set its execution to net",
    severity="warning",
    guard=lambda node_net, index: node_net.reaction is not None,
)
def reaction_usable(node_net: sym.NodeNet, index: Index) -> Outcome:
    """A node net with a reaction has the execution net: the engine takes that long."""
    return not runs_callbacks(node_net)


@constraint(
    "{it} takes callbacks in the order {element.order}, but does not run callbacks",
    fix="set its execution to callbacks, or its order to any",
    severity="warning",
    guard=lambda node_net, index: node_net.order != sym.CallbackOrder.any,
)
def order_usable(node_net: sym.NodeNet, index: Index) -> Outcome:
    """A node net with an order of callbacks runs callbacks."""
    return runs_callbacks(node_net)
