"""What waits at most in the histories of servers and clients, by what clients have under way at once."""

from __future__ import annotations

from dineros.analysis.bounds.followed import Requests, require_held
from dineros.analysis.bounds.solving import Solved
from dineros.analysis.bounds.tasks import Task
from dineros.analysis.bounds.work import NotBoundedError
from dineros.analysis.latencies.histories import history_name
from dineros.metamodel import sym
from dineros.metamodel.callbacks.under_way import goal_counts
from dineros.metamodel.calls import HISTORY_DEPTH, UNLIMITED
from dineros.metamodel.elements import channels, node_nets

Waiting = tuple[int, bool | None]
"""The greatest number that waits, and whether the history can overflow; None if that is not known."""
Histories = dict[str, tuple[Waiting, str]]
"""By name, what waits, and why something is open."""

_ANY = "nothing limits how many the clients have under way at once"
_DEEPER = "bounds allow more waiting requests than its depth"
_FIRST = "a client of several goals can take results before answers"
_FEEDBACK = "bounds do not follow feedback"


def histories_of_calls(
    model: sym.SystemModel, tasks: list[Task], solved: Solved
) -> dict[str, tuple[Waiting, str]]:
    """Return what waits at most in histories of calls, goals and their feedback, and why something is open.

    `tasks`, `solved`: the callbacks of the model, and their bounds.
    """
    # What a node that stops has not taken is lost, whatever fits.
    comes_and_goes = any(node.lifecycle is not None for node in node_nets(model))
    found: Histories = {}

    def add(kind: str, place: object, depth: int, most: int | None, reason: str) -> None:
        is_kept = most is not None and not comes_and_goes
        longest = depth if most is None or comes_and_goes else most
        reason = "a managed node loses what it has not taken when it stops" if comes_and_goes else reason
        found[history_name(kind, place)] = (longest, False if is_kept else None), reason

    requests = Requests(model)
    for service in channels(model, sym.ServiceChannel):
        depth = int(service.depth)
        served = [task for task in tasks if task.server is service.server and task in solved.waited]
        held = _held(service, requests)
        longest = solved.waited[served[0]].longest if served else None
        if longest is None or (held is not None and held < longest):
            longest = held
        longest = None if longest is None or longest > depth else longest
        tasks_of = [task for task in tasks if task.server is service.server]
        reason = next((solved.reasons[task] for task in tasks_of if task in solved.reasons), _DEEPER)
        add("request", service.server.entry, depth, longest, reason)
        for client in service.clients:
            add("response", client.response, depth, requests.of(client), _ANY)
    goals = goal_counts(model)
    for action in channels(model, sym.ActionChannel):
        sent = [goals[sender] for sender in action.clients]
        add("goal", action.server.entry, HISTORY_DEPTH, None if UNLIMITED in sent else sum(sent), _ANY)
        for sender in action.clients:
            known = None if goals[sender] == UNLIMITED else goals[sender]
            add("result", sender.goal, HISTORY_DEPTH, known, _ANY)
            if sender.accepted is not None or action.server.mayReject:
                # Acceptances can gather: a client of several goals can take results first.
                told = known if sender.accepted is None or known == 1 else None
                add("answer", sender.goal, HISTORY_DEPTH, told, _ANY if known is None else _FIRST)
            if sender.feedback is not None and action.server.feedback is not None:
                add("feedback", sender.feedback, int(action.depth), None, _FEEDBACK)
    return found


def _held(service: sym.ServiceChannel, requests: Requests) -> int | None:
    """Return how many requests clients have under way at once at most; None without a limit."""
    try:
        require_held(service.server)
    except NotBoundedError:
        return None
    return requests.all_of(service.clients)
