"""A model without one of its faults: the smallest change that removes the fault.

Ports that do not match get the quality of service that is asked for, and what is published while a subscriber
is not there is kept for it. A clause that can never be true is left out. If callbacks wait for each other,
groups and threads are changed, the fewest first, until none of them waits any more; if a few such changes
are not enough, the calls of the circle get time-outs, so that its callbacks end. A server that never receives
requests to cancel gets another thread. A callback that waits forever gets what it waits for: a time-out of
its call, or a transition that gives the token. A client whose request is lost with its server gets a
time-out, too. A place that grows gets a capacity, or no tokens at all if nothing ever looks at it.
"""

from __future__ import annotations

from collections.abc import Callable

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.clauses import Clauses
from dineros.analysis.checks.goals import Goals
from dineros.analysis.checks.matching import Matching
from dineros.analysis.checks.overflow import Presence
from dineros.analysis.checks.unused import NO_RETURN
from dineros.analysis.consequences.circle_fixes import Fix, against_waiting, end_call, with_settings
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, here, inhibit
from dineros.metamodel.callbacks.groups import threads_of, works_on_goals
from dineros.metamodel.clauses import remove_clause
from dineros.metamodel.elements import channels, find, is_unseen, node_net_of, pages, resolve
from dineros.metamodel.matching import mismatch
from dineros.metamodel.settings import apply

_KEPT = {"durability": "transientLocal", "reliability": "reliable"}
"""Qualities of service with which who subscribes later gets the messages that were kept."""


ENOUGH = 10
"""Tokens that a place may still hold whose growth is stopped: few of them would fix more than that."""


def fix_of(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Return the change that removes a fault from a model; None if no such change is known.

    `model`: the model; it is not changed.

    Raises
    ------
    BudgetExceededError
        If time runs out.
    """
    find_fix = _FIXES.get(finding.rule)
    return None if find_fix is None else find_fix(model, finding, budget)


def is_cause(model: pn.Net, finding: Finding) -> bool:
    """Return whether a fault is of a kind that may have consequences.

    A service that never returns is a cause if no node that serves it was seen. Otherwise, something in its
    server is the cause.
    """
    if finding.rule == NO_RETURN.rule:
        return is_unseen(node_net_of(find(model, finding.elements[0], sym.ServiceChannel).server.entry))
    return finding.rule in _FIXES


def is_effect(finding: Finding) -> bool:
    """Return whether a fault of such a kind may itself be a consequence."""
    return finding.rule == Callbacks.ENDLESS.rule


def is_proved(rule: str) -> bool:
    """Return whether a change is known to remove a fault of this kind: by a proof, or by its nature."""
    return rule in (
        Callbacks.CIRCLE.rule,
        Matching.NOT_MATCHED.rule,
        Clauses.UNSATISFIABLE.rule,
        NO_RETURN.rule,
    )


def _against_mismatch(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    channel, publisher, subscriber = finding.elements

    def fix(copied: sym.SystemModel) -> None:
        topic = find(copied, channel, sym.TopicChannel)
        offers = next(port for port in topic.publishers if port.place.id == publisher)
        asks = next(port for port in topic.subscribers if port.place.id == subscriber)
        while (found := mismatch(offers, asks)) is not None:
            apply(copied, found.settings[0])

    return fix


def _against_absence(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Let the publisher keep its messages for who comes later; None if the model is changed so already.

    A message that was kept reaches who comes later only if it is repeated until it arrives.
    """
    channel, publisher, subscriber = finding.elements
    topic = find(model, channel, sym.TopicChannel)
    ports = {
        "publisher": next(port for port in topic.publishers if port.place.id == publisher),
        "subscriber": next(port for port in topic.subscribers if port.place.id == subscriber),
    }
    settings = [
        f"{channel}.{kind}.{port.place.id}.qos.{quality}={value}"
        for kind, port in ports.items()
        for quality, value in _KEPT.items()
        if port.qos is None or str(getattr(port.qos, quality)) != value
    ]
    return with_settings(settings) if settings else None


def _against_clause(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    return lambda copied: remove_clause(find(copied, finding.elements[0], sym.Transition))


def _against_unheard(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    action = find(model, finding.elements[0], sym.ActionChannel)
    node = node_net_of(action.server.page)
    if node is None:
        return None
    threads = threads_of(node) + 1
    return with_settings([f"{node.id}.executor=multi", f"{node.id}.threads={threads}"])


def _against_lost_request(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Let the client of a request that is lost with its server continue without the response."""
    channel, asked = finding.elements[0], set(finding.elements)

    def fix(copied: sym.SystemModel) -> None:
        for client in find(copied, channel, sym.ServiceChannel).clients:
            if client.request.id in asked:
                end_call(client)

    return fix


def _against_unserved(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Let the clients of a service that no seen node serves continue without a response."""

    def fix(copied: sym.SystemModel) -> None:
        for client in find(copied, finding.elements[0], sym.ServiceChannel).clients:
            end_call(client)

    return fix


def _against_endless(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Provide what a callback waits for: a time-out in place of a response, otherwise a new transition."""
    witness = finding.witness
    if witness is None or witness.subject is None:
        return None
    marking = witness.ends_at(witness.subject)
    assert marking is not None, "it is of this net"
    lacking = Waiting(witness.subject).lacking(finding.elements[0], marking)
    clients = {
        str(client.response.id): client
        for service in channels(model, sym.ServiceChannel)
        for client in service.clients
    }
    page = find(model, finding.elements[0], sym.CallbackPage)
    is_copied = page.kind == sym.CallbackKind.server or works_on_goals(page)
    copied_places = {str(part.id) for part in page.eAllContents() if isinstance(part, pn.Place)}
    if not lacking or (is_copied and not copied_places.isdisjoint(set(lacking) - clients.keys())):
        return None  # a giver outside of a page that is copied would give to none of the copies

    def fix(copied: sym.SystemModel) -> None:
        for service in channels(copied, sym.ServiceChannel):
            for client in service.clients:
                if client.response.id in lacking:
                    end_call(client)
        for id in lacking:
            if id not in clients:
                _give(find(copied, id, pn.Place))

    return fix


def _give(place: pn.Place) -> None:
    """Add a transition to the node of a place that puts a token there whenever there is none."""
    net = node_net_of(place)
    assert net is not None
    giver = sym.Transition(id=f"{place.id}.giver", page=net)
    here_place = here(place, net)
    flow(giver, here_place)
    inhibit(here_place, giver)


def _empty(place: pn.Place, most: int) -> None:
    """Add a transition to the node of a place that takes the tokens of the full place."""
    net = node_net_of(place)
    assert net is not None
    emptied = sym.Transition(id=f"{place.id}.emptied", page=net)
    here_place = here(place, net)
    flow(here_place, emptied)
    emptied.incoming[0].weight = most


def _against_growth(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Stop the growth where a capacity does; None if clients would have to wait for an acknowledgement.

    If no transition and no property reads a growing place, its tokens are left out, which changes nothing
    else. If a property reads it, the place keeps `ENOUGH` tokens at most, and a transition empties it. So a
    property that is violated by fewer tokens stays a finding of its own.
    """
    from dineros.analysis.covering.growing import largest_weights
    from dineros.analysis.covering.growth import remedy_of

    subject = None if finding.witness is None else finding.witness.subject
    remedy = None if subject is None else remedy_of(subject.net)
    if subject is None or remedy is None or len(remedy.weights) > 1:
        return None
    looked_at, grown = largest_weights(subject.net), {}
    growing = [p for p in remedy.counters if subject.place_text(p) in finding.elements]
    for place in (*remedy.weights, *growing):
        link = subject.link_of(subject.net.places[place])
        source = None if link is None or link.meaning is not None else link.sources[0]
        if not isinstance(source, sym.Place):
            return None
        grown[str(source.id)] = looked_at[place] and max(remedy.credits, looked_at[place], ENOUGH)
    asked = [
        id
        for id, most in grown.items()
        if not most and any(id in (property.text or "") for property in model.properties)
    ]
    for id in asked:
        grown[id] = ENOUGH

    def fix(copied: sym.SystemModel) -> None:
        for id, most in grown.items():
            if most:
                find(copied, id, sym.Place).capacity = most
        for id in asked:
            _empty(find(copied, id, sym.Place), ENOUGH)
        for page in pages(copied):
            for arc in list(page.arcs):
                if grown.get(str(resolve(arc.target).id)) == 0:
                    arc.source.outgoing.remove(arc)
                    arc.target.incoming.remove(arc)
                    page.arcs.remove(arc)

    return fix if grown else None


_FIXES: dict[str, Callable[[sym.SystemModel, Finding, Budget], Fix | None]] = {
    Matching.NOT_MATCHED.rule: _against_mismatch,
    Clauses.UNSATISFIABLE.rule: _against_clause,
    Presence.MISSED.rule: _against_absence,
    Presence.UNSERVED.rule: _against_lost_request,
    Presence.UNANSWERED.rule: _against_lost_request,
    NO_RETURN.rule: _against_unserved,
    Callbacks.CIRCLE.rule: against_waiting,
    Callbacks.ENDLESS.rule: _against_endless,
    Goals.UNHEARD.rule: _against_unheard,
    Boundedness.UNBOUNDED.rule: _against_growth,
}
"""Kinds of faults that others may be consequences of, with what finds a change against each."""
