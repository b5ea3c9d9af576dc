"""The threads of executors whose number the code does not say, and whether answers depend on that number.

More threads than callbacks that can run at the same time change nothing: callbacks of one exclusive group run
one after the other. So the assumed number matters only for nodes with more groups than the least possible
number of threads, with reentrant groups, or with callbacks that belong to no group. An executor that the code
does not show may also run other nodes: then callbacks that wait or take time keep these from a thread.
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.observation.importing.flows.labels import WAITS, Label, Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode, OpenThreads
from dineros.observation.systems import ObservedNode, ObservedSystem
from dineros.sources.facts import NodeFact, is_open

PROCESSORS = 4
"""Assumed threads of an executor with one thread per processor."""
LEAST_OF_RCLCPP = 2
"""Least threads of a `rclcpp` executor with one thread per processor; of `rclpy`, a single one."""
"""Steps that keep a thread until something else happens."""


def threads_in_code(fact: NodeFact, at: str) -> tuple[int | None, OpenThreads | None]:
    """Return the threads of a spun node, and what the code states about them if it does not give a number.

    `at`: its line of code, with the folder.
    """
    apart = sum(fact.apart.values())
    if isinstance(fact.threads, int):
        return fact.threads + apart, None
    if fact.threads == "processors":
        least = apart + (1 if fact.at.file.endswith(".py") else LEAST_OF_RCLCPP)
        return PROCESSORS + apart, OpenThreads(at, "as many threads as processors", least)
    is_unknown = not fact.executor or is_open(fact.executor)
    words = fact.executor if is_unknown and fact.executor else fact.threads
    return 1 + apart if apart else None, OpenThreads(
        at, f"the number of threads is {words}", may_be_shared=is_unknown
    )


def lacks_of_threads(system: ObservedSystem, given: Given) -> tuple[str, ...]:
    """Return the assumed numbers of threads on which answers may depend, a line for each.

    Parameters
    ----------
    system : ObservedSystem
        The nodes; those that share an executor are joined.
    given : Given
        The facts of the code, overridden by those that users give.
    """
    found = []
    for node in system.nodes:
        said = given.nodes.get(node.name, GivenNode())
        opened = said.open_threads
        if opened is not None and _matters(node, said, opened):
            threads = said.threads or 1
            verb = "is" if threads == 1 else "are"
            found.append(f"{opened.at}: {opened.words}; {threads} {verb} assumed for node {node.name}")
    return tuple(found)


def _matters(node: ObservedNode, said: GivenNode, opened: OpenThreads) -> bool:
    """Return whether answers may depend on the number of threads."""
    most = _most_at_once(node, said)
    if most is None or most > opened.least:
        return True
    return opened.may_be_shared and any(_keeps_a_thread(each, node) for each in said.callbacks.values())


def _most_at_once(node: ObservedNode, said: GivenNode) -> int | None:
    """Return how many callbacks of a node can run at the same time; None: not limited by groups."""
    groups = {callback.group for callback in said.callbacks.values()}
    if any(said.groups.get(group or "") == "reentrant" for group in groups) or node.action_servers:
        return None
    if not said.answers_hold_groups and (node.clients or node.action_clients):
        return None  # in `rclpy` the callbacks of responses are in no group
    return len(groups)


def _keeps_a_thread(callback: GivenCallback, node: ObservedNode) -> bool:
    """Return whether a callback may wait or take time."""
    if callback.takes is not None and callback.takes != (0, 0):
        return True
    if callback.does is None and (node.clients or node.action_clients):
        return True
    return any(isinstance(each, Step) and each.verb in WAITS for each in _labels(callback))


def _labels(callback: GivenCallback) -> Iterator[Label]:
    yield from callback.does or ()
    flows = [callback.flow, callback.accepted, callback.rejected]
    if callback.received is not None:
        flows += [flow for _, flow in callback.received.branches]
    for flow in flows:
        for edge in () if flow is None else flow.edges:
            yield edge.label
