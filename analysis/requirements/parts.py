"""Bounds of times and invariants that a few nodes of a model decide, however much the others do.

Places of other nodes, and of channels to them, are left out (`dineros.analysis.timed.reductions.cuts`): these
nodes may then do anything at any time. What holds so holds in the whole model. First only the nodes that the
formula names are analysed; then also all nodes that send them messages; then also those that share services
and actions with them, and the nodes that send these reliable messages.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.graphs.predicates import MarkingMatrix, combination, holds
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeEnabled, SomeFired
from dineros.analysis.logic.language.bounded import Bounded
from dineros.analysis.logic.language.syntax import QUANTIFIERS, TEMPORAL, Fired, Formula, Globally
from dineros.analysis.timed.durations.stopping import always_within
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.reductions.cuts import restricted
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import channels, node_net_of, resolve
from dineros.metamodel.matching import are_matched, is_best_effort

BY_MARKINGS = "state classes of some nodes"
EXPLORED = Share(most_states=100_000)
"""Limit of the classes of a part, by inclusion; a larger one is not analysed."""
PART = Share(time=0.6, most_states=1_500_000)
"""Share of each part; its classes with the observer are limited."""
Nodes = frozenset[sym.NodeNet]


def holds_in_part(subject: TimedSubject, formula: Formula, budget: Budget) -> Outcome | None:
    """Prove that all runs satisfy a formula by some nodes; None if they do not prove it.

    `formula`: bounds times, or says what holds in all markings.
    """
    model = subject.model
    if not isinstance(formula, Bounded) and not _is_invariant(formula):
        return None
    if not isinstance(model, sym.SystemModel) or subject.timed.has_priorities:
        return None
    asked = _asked(subject, formula)
    if asked is None:
        return None
    places, fired = asked
    nodes_of = _nodes_by_place(subject)
    first = frozenset(node for place in places for node in nodes_of[place]).union(
        node
        for t in fired
        if (link := subject.link_of(subject.net.transitions[t])) is not None
        for source in link.sources
        for node in _nodes_of(source)
    )
    every = frozenset(node for nodes in nodes_of for node in nodes)
    for nodes in _growing(model, first):
        if nodes >= every:
            continue
        kept = {place for place, own in enumerate(nodes_of) if own <= nodes}
        found = _holds(subject, formula, kept, asked, PART.share(budget))
        if found is not None:
            return found
    return None


def _holds(
    subject: TimedSubject,
    formula: Formula,
    kept: set[int],
    asked: tuple[set[int], set[int]],
    budget: Budget,
) -> Outcome | None:
    """Prove it with these places; those to which tokens come without end are left out, too."""
    while True:
        part = restricted(subject.timed, kept) if _tells(subject.timed, kept, *asked) else None
        if part is None:
            return None
        explored = explore_timed(part, EXPLORED.share(budget))
        if explored.growth is None:
            break
        kept -= set(explored.growth.places)
    if not explored.is_complete:
        return None
    if isinstance(formula, Bounded):
        return always_within(part, formula, subject.names, budget)
    atoms = BoundAtoms(subject.net, formula, subject.names).conditions
    matrix = MarkingMatrix(part.untimed, explored.markings)
    is_met = combination(formula.operands[0], lambda atom: holds(matrix, atoms[atom]), len(explored.markings))
    if not is_met.all():
        return None
    return Outcome("holds", states=explored.search.classes, seconds=budget.spent, by=BY_MARKINGS)


def _is_invariant(formula: Formula) -> bool:
    """Return whether a formula says that all markings satisfy a condition."""
    if not isinstance(formula, Globally):
        return False
    parts = formula.operands[0].subformulas()
    return not any(isinstance(part, (*TEMPORAL, *QUANTIFIERS, Fired)) for part in parts)


def _tells(net: TimedNet, kept: set[int], places: set[int], fired: set[int]) -> bool:
    """Return whether these places determine all places and firings that a formula names."""
    return kept >= places and all(
        any(place in kept for place, _ in (*net.take.row(t), *net.put.row(t))) for t in fired
    )


def _asked(subject: TimedSubject, formula: Formula) -> tuple[set[int], set[int]] | None:
    """Return the places and transitions that a formula names; None if a part does not decide it."""
    net = subject.net
    places: set[int] = set()
    fired: set[int] = set()
    for asked in BoundAtoms(net, formula, subject.names).conditions.values():
        match asked:
            case Linear(factors):
                places.update(factors)
            case SomeFired(transitions):
                fired.update(transitions)
            case SomeEnabled(transitions) if all(subject.timed.take.row(t) for t in transitions):
                tests = (*(net.pre.row(t) for t in transitions), *(net.inhibitor.row(t) for t in transitions))
                places.update(place for row in tests for place, _ in row)
            case _:
                return None
    return places, fired


def _nodes_by_place(subject: TimedSubject) -> list[Nodes]:
    """Return by place of the net the nodes that it belongs to: those at the ends of a channel."""
    found: list[Nodes] = [frozenset()] * len(subject.net.places)
    heard = {
        id(end): frozenset(node for writer in topic.publishers for node in _nodes_of(writer))
        for topic in channels(subject.model, sym.TopicChannel)
        for reader in topic.subscribers
        for end in (reader, resolve(reader.place))
    }
    for link in subject.links():
        if isinstance(link.target, pn.Place):
            nodes = frozenset(node for source in link.sources for node in _nodes_of(source))
            if not nodes:
                nodes = frozenset(
                    node for source in link.sources for port in _ports(source) for node in _nodes_of(port)
                )
            found[subject.place_index[link.target.id]] = nodes.union(
                *(heard.get(id(source), frozenset()) for source in link.sources)
            )
    return found


def _nodes_of(element: EObject) -> Iterator[sym.NodeNet]:
    """Yield the node of an element, or of a port."""
    if isinstance(element, sym.TopicPort):
        element = element.place
    elif isinstance(element, sym.ServerPort | sym.ActionServerPort):
        element = element.entry
    elif isinstance(element, sym.ClientPort):
        element = element.request
    elif isinstance(element, sym.ActionClientPort):
        element = element.goal
    node = node_net_of(element)
    if node is not None:
        yield node


def _ports(channel: EObject) -> Iterable[EObject]:
    if isinstance(channel, sym.ServiceChannel | sym.ActionChannel):
        return (channel.server, *channel.clients)
    return (*channel.publishers, *channel.subscribers) if isinstance(channel, sym.TopicChannel) else ()


def _growing(model: sym.SystemModel, nodes: Nodes) -> Iterator[Nodes]:
    """Yield some nodes of a model; then also those that send them messages, or that they work with."""
    yield nodes
    calls = [
        frozenset(node for port in _ports(channel) for node in _nodes_of(port))
        for kind in (sym.ServiceChannel, sym.ActionChannel)
        for channel in channels(model, kind)
    ]
    sends = [
        (frozenset(_nodes_of(writer)), frozenset(_nodes_of(reader)), is_best_effort(writer, reader))
        for topic in channels(model, sym.TopicChannel)
        for writer in topic.publishers
        for reader in topic.subscribers
        if are_matched(writer, reader)
    ]

    def with_senders(nodes: Nodes, also_unsure: bool) -> Nodes:
        return nodes.union(
            *(writer for writer, reader, is_unsure in sends if reader & nodes and is_unsure <= also_unsure)
        )

    heard, before = with_senders(nodes, also_unsure=True), nodes
    while heard != before:
        before, heard = heard, with_senders(heard, also_unsure=True)
    if heard != nodes:
        yield heard
    while True:
        more = nodes.union(*(each for each in calls if each & nodes))
        if more == nodes:
            more = with_senders(nodes, also_unsure=False)
        if more == nodes:
            return
        nodes = more
        yield nodes
