"""What is done with a model: it is flattened in variants, and each is compared with the interpreter."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.under_way import goal_counts
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.equal_behaviour import Comparison, compare
from tests.support.references.flattening import plain_net_of
from tests.support.references.histories import are_matched, quality_of
from tests.support.references.lifecycles import LifecycleInterpreter, is_kept


def variants(
    model: sym.SystemModel,
    states: int,
    signals: Sequence[SignalVariant],
    overflow: Sequence[OverflowVariant],
) -> Iterator[tuple[SignalVariant, OverflowVariant, Comparison]]:
    """Yield how the nets of a model compare with the interpreter, up to a number of states each."""
    for signal_variant in signals:
        interpreter = LifecycleInterpreter(model, signal_variant)
        for overflow_variant in overflow:
            net = plain_net_of(flatten(model, signal_variant, overflow_variant).net)
            yield signal_variant, overflow_variant, compare(net, interpreter, states)


def features_of_model(model: sym.SystemModel) -> set[str]:
    """Return what a model has of what the rules of ROS 2 look at."""
    found = set()
    pages = {c.server.page for c in model.channels if isinstance(c, sym.ServiceChannel)}
    for channel in model.channels:
        if isinstance(channel, sym.ServiceChannel):
            found.add("with services")
            if any(client.request.page in pages for client in channel.clients):
                found.add("with calls on server pages")
            clients = list(channel.clients)
            if any(client.timeout is not None for client in clients):
                found.add("with time-outs")
                if any(client.timeout is not None and client.request.page in pages for client in clients):
                    found.add("with time-outs on server pages")
            asked = {LifecycleInterpreter(model).outstanding[client] for client in clients}
            if any(number > 1 for number in asked):
                found.add("with several requests of a client")
            if -1 in asked:
                found.add("with clients that do not wait")
            continue
        if isinstance(channel, sym.ActionChannel):
            found |= _features_of_action(model, channel)
            continue
        assert isinstance(channel, sym.TopicChannel)
        found.add("with topics")
        if any(port.inHand is not None for port in channel.subscribers):
            found.add("with messages in hand")
        if any(port.place.page in pages for port in channel.publishers):
            found.add("with publishers on server pages")
        for writer in channel.publishers:
            for reader in channel.subscribers:
                found.add("with matched pairs" if are_matched(writer, reader) else "with pairs not matched")
                if is_kept(writer, reader):
                    found.add("with messages kept for late readers")
                if "bestEffort" in {str(quality_of(port).reliability) for port in (writer, reader)}:
                    found.add("with best effort")
    events = [event.name for event in LifecycleInterpreter(model).events]
    if any(re.search(r"\.client\.[^.]*(\[\d+\]\.[^.]*)?\.drop$", name) for name in events):
        found.add("with requests that can be lost")
    for element in model.eAllContents():
        if isinstance(element, pn.Place) and element.capacity is not None:
            found.add("with capacities of places")
        if isinstance(element, sym.Transition) and element.clause is not None:
            found.add("with clauses")
    return found | _features_of_callbacks(model) | _features_of_lifecycles(model)


def _features_of_action(model: sym.SystemModel, action: sym.ActionChannel) -> set[str]:
    """Return what an action has of what its rules look at."""
    found, server = {"with actions"}, action.server
    for outcome in ("succeeded", "aborted", "canceled"):
        if getattr(server, outcome) is not None:
            found.add(f"with goals that may be {outcome}")
    if server.mayReject:
        found.add("with goals that may be refused")
    if server.feedback is not None and any(client.feedback is not None for client in action.clients):
        found.add("with feedback")
    if any(client.cancel is not None for client in action.clients):
        found.add("with cancels" if server.cancel is not None else "with cancels that are refused")
    if len(action.clients) > 1:
        found.add("with several clients of an action")
    asked = {goal_counts(model)[client] for client in action.clients}
    if any(number > 1 for number in asked):
        found.add("with several goals of a client")
    if -1 in asked:
        found.add("with clients that do not wait for goals")
    return found


def _features_of_callbacks(model: sym.SystemModel) -> set[str]:
    """Return what a model has of what the rules about timers and executors look at."""
    found = set()
    for element in model.eAllContents():
        if isinstance(element, sym.CallbackPage):
            found.add(f"with {element.kind} callbacks")
            if element.awaits:
                found.add("with callbacks that await")
        if isinstance(element, sym.NodeNet) and str(element.execution) == "callbacks":
            found.add("with nodes that run callbacks")
            if element.threads > 1:
                found.add("with several threads")
            if any(str(group.kind) == "reentrant" for group in element.callbackGroups):
                found.add("with reentrant groups")
    return found


def _features_of_lifecycles(model: sym.SystemModel) -> set[str]:
    """Return what a model has of what the rules about managed nodes look at."""
    lives = [each for each in model.eAllContents() if isinstance(each, sym.Lifecycle)]
    found = {"with managed nodes"} if lives else set()
    if any(life.configureStep or life.activateStep for life in lives):
        found.add("with a start order")
    if any(life.cleansUp for life in lives):
        found.add("with nodes that are cleaned up")
    if any(life.shutsDown for life in lives):
        found.add("with nodes that are shut down")
    events = [event.name for event in LifecycleInterpreter(model).events]
    if any(".replace" in name for name in events):
        found.add("with readers that come again")
    for word, feature in (
        (".miss", "with requests that find no server"),
        (".left", "with requests that are lost with a server"),
        (".again", "with requests that are sent again"),
    ):
        if any(".client." in name and name.endswith(word) for name in events):
            found.add(feature)
    return found
