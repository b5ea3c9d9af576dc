"""Who runs a callback: threads of an executor, callback groups, and what responses do.

>>> from dineros.metamodel import sym
>>> threads_of(sym.NodeNet(id="node", executor="multi", threads=3)), threads_of(sym.NodeNet(id="node"))
(3, 1)
"""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import node_net_of


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


def answered_on(page: sym.CallbackPage) -> list[sym.ClientPort]:
    """Return the clients whose responses begin the callback of a page."""
    return [
        client
        for client in clients_beside(page)
        if begins_callback(client) and callback_page_of(client.response) is page
    ]


def clients_beside(element: EObject | None) -> list[sym.ClientPort]:
    """Return all clients of the system model that an element is in."""
    while element is not None and not isinstance(element, sym.SystemModel):
        element = element.eContainer()
    if element is None:
        return []
    services = [channel for channel in element.channels if isinstance(channel, sym.ServiceChannel)]
    return [client for service in services for client in service.clients]


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
    return page is not None and bool(page.awaits) and page is callback_page_of(client.response)


def group_or_node(asking: sym.CallbackPage | sym.ClientPort) -> EObject | None:
    """Return the callback group of a callback or a client, or the node net whose own group it is in.

    What a response begins is in no group where it names none: rclpy has its executor run the callbacks of a
    future as tasks of their own (`rclpy.task.Future.add_done_callback`).
    """
    if asking.group is not None:
        return asking.group
    if isinstance(asking, sym.ClientPort):
        return node_net_of(asking.response)
    return None if asking.kind == sym.CallbackKind.client else node_net_of(asking)


def members_of(group: EObject) -> list[sym.CallbackPage | sym.ClientPort]:
    """Return the callback pages and client ports in a callback group, or in the one of a node net."""
    node = node_net_of(group)
    asking: list[sym.CallbackPage | sym.ClientPort] = [
        client for client in clients_beside(node) if node_net_of(client.response) is node
    ]
    if node is not None:
        asking.extend(each for each in node.eAllContents() if isinstance(each, sym.CallbackPage))
    return [each for each in asking if group_or_node(each) is group]
