"""Who runs a callback: threads of an executor, callback groups, and what responses do.

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
"""What may be in a callback group."""


def callback_page_of(element: EObject | None) -> sym.CallbackPage | None:
    """Return the innermost callback page that an element stands on, itself included."""
    while element is not None and not isinstance(element, sym.CallbackPage):
        element = element.eContainer()
    return element


def runs_callbacks(node: sym.NodeNet | None) -> bool:
    """Tell whether executor and callback groups say what a node may do at once."""
    return node is not None and node.execution == sym.Execution.callbacks


def threads_of(node: sym.NodeNet) -> int:
    """Return how many callbacks of a node may run at once, whatever their groups are."""
    return node.threads if node.executor == sym.Executor.multi else 1


def works_on_goals(page: sym.CallbackPage) -> bool:
    """Tell whether a callback works on goals of an action: it needs a thread, and waits for no group."""
    return page.kind == sym.CallbackKind.goal


def holds_thread(page: sym.CallbackPage) -> bool:
    """Tell whether a callback has a thread while it runs; what awaits at each step of a goal has none."""
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
    """Return all clients of services of the system model that an element is in."""
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
    """Tell whether what comes to a place of an action's client begins a callback: its page sent no goal."""
    page = callback_page_of(place)
    return (
        page is not None
        and page.kind == sym.CallbackKind.client
        and page is not callback_page_of(client.goal)
    )


def is_goal_awaited(client: sym.ActionClientPort) -> bool:
    """Tell whether a callback gives its thread back while it waits for how its goal ends."""
    page = callback_page_of(client.goal)
    if page is None or not page.awaits:
        return False
    return any(callback_page_of(place) is page for place in answers(client))


def begins_callback(client: sym.ClientPort) -> bool:
    """Tell whether responses begin a callback of their own: they come to a client page, which did not ask."""
    page = callback_page_of(client.response)
    return (
        page is not None
        and page.kind == sym.CallbackKind.client
        and page is not callback_page_of(client.request)
    )


def is_awaited(client: sym.ClientPort) -> bool:
    """Tell whether a callback gives its thread back while it waits for a response to a request of its own."""
    page = callback_page_of(client.request)
    if page is None or not page.awaits or works_on_goals(page):
        return False
    return page is callback_page_of(client.response)


def group_or_node(asking: Asking) -> EObject | None:
    """Return the callback group of a callback or a client, or the node net whose own group it is in.

    What a response, a result or feedback begins is in no group where it names none: its executor runs
    the callbacks of a future as tasks of their own (`rclpy.task.Future.add_done_callback`). That of a goal's
    page takes goals and requests to cancel; what works on a goal does not wait for it.
    """
    if asking.group is not None:
        return asking.group
    if isinstance(asking, sym.CallbackPage) and asking.kind == sym.CallbackKind.client:
        return None
    return node_net_of(place_of(asking))


def place_of(asking: Asking) -> EObject:
    """Return what of a callback, client or server stands on a node net."""
    match asking:
        case sym.ClientPort():
            return asking.response
        case sym.ActionClientPort():
            return asking.goal
    return asking


def members_of(group: EObject) -> list[Asking]:
    """Return the callback pages and ports in a callback group, or in the one of a node net."""
    return [each for each in _askings(node_net_of(group)) if group_or_node(each) is group]


def has_clients(node: sym.NodeNet) -> bool:
    """Tell whether clients of services or actions are in callback groups of a node, or in its own."""
    groups = {node, *node.callbackGroups}
    ports = (each for each in _askings(node) if not isinstance(each, sym.CallbackPage))
    return any(group_or_node(each) in groups for each in ports)


def _askings(node: sym.NodeNet | None) -> list[Asking]:
    """Return the callback pages and ports of a node net, whatever group they are in."""
    ports: list[Asking] = [*clients_beside(node)]
    for action in _actions_beside(node):
        ports.extend(action.clients)
    asking = [port for port in ports if node_net_of(place_of(port)) is node]
    if node is not None:
        asking.extend(each for each in node.eAllContents() if isinstance(each, sym.CallbackPage))
    return asking
