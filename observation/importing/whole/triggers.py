"""Which topics, services and actions are used without anything from outside of the described nodes.

Two nodes that only call each other's services never begin: another program has to call one of them first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from dineros.observation.importing.assuming import of_client
from dineros.observation.importing.flows.labels import Flow, Step
from dineros.observation.importing.given import Given, GivenCallback
from dineros.observation.systems import ObservedNode

Channel = tuple[str, str]
"""A kind (``publishers``, ``clients``, ``action_clients``: the port that uses it), and a name."""

_KINDS = {"publish": "publishers", "call": "clients", "send": "clients", "goal": "action_clients"}
_SERVED = {"publishers": "subscribers", "clients": "servers", "action_clients": "action_servers"}


def used_by_themselves(nodes: Sequence[ObservedNode], given: Given) -> set[Channel]:
    """Return the channels that nodes use once they run: from timers and threads on, step by step.

    A channel that no node uses counts as used from outside, so what it triggers counts as well.

    Examples
    --------
    A timer publishes ``/a``, and the subscriber of ``/a`` calls ``/b``: both are used. The callback of
    service ``/c`` calls ``/d``, and the callback of ``/d`` calls ``/c``: neither is used.
    """
    known = {channel for node in nodes for channel in _all_of(node)}
    used: set[Channel] = set()
    before = -1
    while len(used) != before:
        before = len(used)
        for node in nodes:
            for needs, callback in _callbacks(node, given):
                if needs is None or needs in used or needs not in known:
                    used.update(_of(callback, node))
    return used


def _callbacks(node: ObservedNode, given: Given) -> Iterator[tuple[Channel | None, GivenCallback]]:
    """Yield the callbacks of a node, each with the channel that starts it; None: it starts by itself."""
    said = given.node(node.name)
    starts: dict[str, Channel] = {}
    for kind, served in _SERVED.items():
        for port in getattr(node, kind):
            if kind != "publishers":
                starts[of_client(port.name)] = starts[port.name] = kind, port.name
        for port in getattr(node, served):
            topic = served == "subscribers"
            starts[port.given_as if topic else port.name] = kind, port.topic if topic else port.name
    if said.timers is None:
        yield None, GivenCallback()
    for name in {**starts, **said.callbacks}:
        yield (
            starts.get(name),
            said.callbacks.get(name, GivenCallback() if _is_port(name, node) else _NOTHING),
        )


_NOTHING = GivenCallback(does=())


def _is_port(name: str, node: ObservedNode) -> bool:
    """Return whether a name is that of a subscription or a server, which has a callback."""
    heard = {port.given_as for port in node.subscribers}
    return name in heard | {port.name for port in (*node.servers, *node.action_servers)}


def _of(callback: GivenCallback, node: ObservedNode) -> Iterable[Channel]:
    """Return the channels that a callback uses; all of its node, if its steps are not given."""
    flows: list[Flow] = [
        each for each in (callback.flow, callback.accepted, callback.rejected) if each is not None
    ]
    if callback.does is None and not flows and callback.received is None:
        return _all_of(node)
    if callback.received is not None:
        flows += [flow for _, flow in callback.received.branches]
    steps = [*(callback.does or ())]
    steps += [edge.label for flow in flows for edge in flow.edges if isinstance(edge.label, Step)]
    return [(_KINDS[step.verb], step.name) for step in steps if step.verb in _KINDS]


def _all_of(node: ObservedNode) -> list[Channel]:
    """Return the channels that a node may use."""
    return [
        (kind, port.topic if kind == "publishers" else port.name)
        for kind in _SERVED
        for port in getattr(node, kind)
    ]
