"""The execution of callbacks: threads of an executor, callback groups, and callbacks of responses.

>>> from dineros.metamodel import sym
>>> threads_of(sym.NodeNet(id="node", executor="multi", threads=3)), threads_of(sym.NodeNet(id="node"))
(3, 1)
"""

from __future__ import annotations

from typing import TypeAlias

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import answers
from dineros.metamodel.elements import channels, node_net_of, system_model_of

Asking: TypeAlias = sym.CallbackPage | sym.ClientPort | sym.ActionClientPort
"""Elements that may be in a callback group."""


def callback_page_of(element: EObject | None) -> sym.CallbackPage | None:
    """Return the innermost callback page around an element, or the element itself."""
    while element is not None and not isinstance(element, sym.CallbackPage):
        element = element.eContainer()
    return element


def runs_callbacks(node: sym.NodeNet | None) -> bool:
    """Return whether executor and callback groups restrict the concurrency of a node."""
    return node is not None and node.execution == sym.Execution.callbacks


def threads_of(node: sym.NodeNet) -> int:
    """Return the maximum number of simultaneous callbacks of a node, ignoring its groups."""
    return node.threads if node.executor == sym.Executor.multi else 1


def works_on_goals(page: sym.CallbackPage) -> bool:
    """Return whether a callback executes goals of an action: it needs a thread, and waits for no group."""
    return page.kind == sym.CallbackKind.goal


def holds_thread(page: sym.CallbackPage) -> bool:
    """Return whether a callback holds a thread while it runs; one that awaits at each step does not."""
    return not (works_on_goals(page) and page.awaits)


def answered_on(page: sym.CallbackPage) -> list[sym.ClientPort | sym.ActionClientPort]:
    """Return the clients whose responses, results or feedback begin the callback of a page."""
    called: list[sym.ClientPort | sym.ActionClientPort] = [
        client
        for client in clients_beside(page)
        if begins_callback(client) and callback_page_of(client.response) is page
    ]
    for action in _actions_beside(page):
        for sender in action.clients:
            heard = [*answers(sender), sender.accepted, sender.feedback]
            if any(begins_answer(sender, place) and callback_page_of(place) is page for place in heard):
                called.append(sender)
    return called


def clients_beside(element: EObject | None) -> list[sym.ClientPort]:
    """Return all service clients of the system model that contains an element."""
    services = channels(system_model_of(element), sym.ServiceChannel)
    return [client for service in services for client in service.clients]


def _actions_beside(element: EObject | None) -> list[sym.ActionChannel]:
    return channels(system_model_of(element), sym.ActionChannel)


def readers_of(page: sym.CallbackPage) -> list[sym.SubscriberPort]:
    """Return the subscriptions whose messages begin a callback."""
    return [
        reader
        for topic in channels(system_model_of(page), sym.TopicChannel)
        for reader in topic.subscribers
        if callback_page_of(reader.place) is page
    ]


def begins_answer(client: sym.ActionClientPort, place: pn.Place | None) -> bool:
    """Return whether messages on a place of an action client begin a callback: its page sent no goal."""
    return _begins_apart(place, client.goal)


def is_goal_awaited(client: sym.ActionClientPort) -> bool:
    """Return whether a callback releases its thread while it waits for the end of its goal."""
    page = callback_page_of(client.goal)
    if page is None or not page.awaits:
        return False
    return any(callback_page_of(place) is page for place in answers(client))


def begins_callback(client: sym.ClientPort) -> bool:
    """Return whether responses begin a separate callback: they arrive on a client page without requests."""
    return _begins_apart(client.response, client.request)


def _begins_apart(answer: pn.Place | None, sender: pn.Place) -> bool:
    page = callback_page_of(answer)
    return page is not None and page.kind == sym.CallbackKind.client and page is not callback_page_of(sender)


def is_awaited(client: sym.ClientPort) -> bool:
    """Return whether a callback releases its thread while it waits for the response to its request."""
    page = callback_page_of(client.request)
    if page is None or not page.awaits or works_on_goals(page):
        return False
    return page is callback_page_of(client.response)


def group_or_node(asking: Asking) -> EObject | None:
    """Return the callback group of a callback or client, or the node net whose default group it is in.

    The callback of a response, a result or feedback is in no group if it names none: its executor runs the
    callbacks of a future as separate tasks (`rclpy.task.Future.add_done_callback`). The group of a goal's
    page applies to accepting goals and cancel requests; the execution of a goal does not wait for it.
    """
    if asking.group is not None:
        return asking.group
    if isinstance(asking, sym.CallbackPage) and asking.kind == sym.CallbackKind.client:
        return None
    return node_net_of(place_of(asking))


def place_of(asking: Asking) -> EObject:
    """Return the element of a callback, client or server that is on a node net."""
    match asking:
        case sym.ClientPort():
            return asking.response
        case sym.ActionClientPort():
            return asking.goal
    return asking


def members_of(group: EObject) -> list[Asking]:
    """Return the callback pages and ports in a callback group, or in the default group of a node net."""
    return [each for each in _askings(node_net_of(group)) if group_or_node(each) is group]


def has_clients(node: sym.NodeNet) -> bool:
    """Return whether callback groups of a node, or its default group, contain clients."""
    groups = {node, *node.callbackGroups}
    ports = (each for each in _askings(node) if not isinstance(each, sym.CallbackPage))
    return any(group_or_node(each) in groups for each in ports)


def _askings(node: sym.NodeNet | None) -> list[Asking]:
    """Return the callback pages and ports of a node net, in any group."""
    ports: list[Asking] = [*clients_beside(node)]
    for action in _actions_beside(node):
        ports.extend(action.clients)
    asking = [port for port in ports if node_net_of(place_of(port)) is node]
    if node is not None:
        asking.extend(each for each in node.eAllContents() if isinstance(each, sym.CallbackPage))
    return asking
