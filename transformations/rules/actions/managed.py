"""Goals of managed nodes (families A and L together): they are inactive before the node is configured.

A goal for an absent server waits for it, as a request does; a goal in a slot stays there until its node is
configured again. While a node is inactive, it accepts and executes goals, and receives events about its own.
"""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.records import Drop
from dineros.transformations.language import Made, Meaning, Node, ancestor
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.feedback import A5, HISTORY, A5Tell
from dineros.transformations.rules.actions.goals import A1, A2, Heard, Taken, Wish
from dineros.transformations.rules.actions.slots import SlotPage
from dineros.transformations.rules.lifecycle import L1, Configuring, Leaves
from dineros.transformations.rules.notation import action_with_client, arc, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class L3Accept(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A server accepts no goal before its node is configured."""

    served = SlotPage()
    node = Node(sym.NodeNet, of=ancestor(served.page, sym.NodeNet))
    accept = Made(A2.accept, of=[served.action, served.slot])
    configured = Made(L1.configured, of=node)

    waits = read(configured, accept)


class L3Goal(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A server refuses no goal and takes no request to cancel before its node is configured."""

    served = SlotPage(upto=1)
    node = Node(sym.NodeNet, of=ancestor(served.page, sym.NodeNet))
    taken = Made(Taken, of=served.action)
    configured = Made(L1.configured, of=node)

    waits = read(configured, taken.move)


class L3Tell(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A server sends no feedback before its node is configured."""

    served = SlotPage()
    node = Node(sym.NodeNet, of=ancestor(served.page, sym.NodeNet))
    tell = Made(A5Tell.tell, of=[served.action, served.slot])
    configured = Made(L1.configured, of=node)

    waits = read(configured, tell)


class L3End(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A server ends no goal before its node is configured."""

    served = SlotPage()
    node = Node(sym.NodeNet, of=ancestor(served.page, sym.NodeNet))
    end = Made(End, of=[served.action, served.slot])
    configured = Made(L1.configured, of=node)

    waits = read(configured, end.move)


class L3Send(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A client sends no goal before its node is configured."""

    client = Node(sym.ActionClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    send = Made(A1.send, of=client)
    configured = Made(L1.configured, of=node)

    waits = read(configured, send)


class L3Wish(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A client asks to cancel no goal before its node is configured."""

    client = Node(sym.ActionClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    wish = Made(Wish, of=client)
    configured = Made(L1.configured, of=node)

    waits = read(configured, wish.move)


class L3Hear(StandardRule, phase=Phase.lifecycle, middleware="ros2"):
    """A client takes no answer and no feedback before its node is configured."""

    client = Node(sym.ActionClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    heard = Made(Heard, of=client)
    configured = Made(L1.configured, of=node)

    waits = read(configured, heard.move)


class L4Feedback(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Feedback that waits at a client is lost when its node is cleaned up or shut down."""

    action, client = action_with_client()
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    received = Made(A5.received, of=client)
    queue = Made(A5.queue, of=client)
    away = Made(L1.away, of=node)

    words = "feedback for {client} of action {action} is lost: node net {node} is not there any more"
    gone = transition(
        "{action.id}.client.{client.client}.feedback.gone",
        Meaning(words, step=Drop, queue="feedback", called=HISTORY, part="gone"),
    )
    clear = transition(
        "{action.id}.client.{client.client}.feedback.clear",
        Meaning(words, step=Drop, queue="feedback", called=HISTORY, part="clear"),
    )
    loses = [arc(received, gone), read(away, gone)]
    clears = [arc(queue.load, clear), arc(clear, queue.capacity), read(away, clear)]

    where = [Leaves(life)]


class L4FeedbackCleared(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """No feedback waits at a client when its node is configured."""

    client = Node(sym.ActionClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.goal, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    bound = Made(A5.bound, of=client)
    queue = Made(A5.queue, of=client)
    change = Made(Configuring, of=node)

    waits = [
        read(bound.free, change.move),
        read(queue.capacity, change.move, weight=queue.capacity.tokens),
    ]
