"""Hypothesis strategy for models, valid or not, that use every feature with values that are hard to carry."""

from __future__ import annotations

import itertools
from typing import TypeVar

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import set_clause
from tests.support.pnml import DINEROS, PNML

T = TypeVar("T")

TEXTS = st.sampled_from(["", " ", " padded ", "a\nb\tc", "<&>\"'", "ä🤖", "x", "{}", "]]>", "\u2028", "\r"])
NUMBERS = st.sampled_from([0.0, -0.5, 1e300, 1 / 3, float("inf"), 12345678901234567.0])
STYLES = ["", "<fill></fill>", "<fill/>", "<position x='1' y='1'/>", "</graphics>", '<x xmlns="urn:x"></x>']

_BLOCK = f'<toolspecific xmlns="{PNML}" tool="{{}}" version="1">{{}}</toolspecific>'
TOOLS = ["other", "", "org.dineros", DINEROS, "ModernPetriEditor"]
CONTENTS = [
    None,
    "no XML",
    _BLOCK.format("other", "<a></a>"),
    _BLOCK.format("other", '<a xmlns="" xmlns:q="urn:q" q:b="1">  text <c></c> </a>'),
    _BLOCK.format("org.dineros", '<element name="evil"></element>'),
    _BLOCK.format(DINEROS, "<type>nodePage</type>"),
    _BLOCK.format("ModernPetriEditor", ""),
    "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>",
]


def _maybe(strategy: st.SearchStrategy[T]) -> st.SearchStrategy[T | None]:
    return st.none() | st.none() | strategy


_points = st.builds(pn.Point, x=NUMBERS, y=NUMBERS)
_graphics = st.builds(
    pn.Graphics,
    positions=st.lists(_points, max_size=2),
    offset=_maybe(_points),
    dimension=_maybe(_points),
    style=_maybe(st.sampled_from(STYLES)),
)
_tool_infos = st.lists(
    st.builds(
        pn.ToolInfo,
        tool=st.sampled_from(TOOLS),
        version=st.sampled_from(["1", "0.2"]),
        content=st.sampled_from(CONTENTS),
    ),
    min_size=1,
    max_size=2,
)
_labels = st.lists(
    st.builds(
        pn.Label,
        kind=st.sampled_from(["elementName", "initialMarking", "inscription"]),
        graphics=_maybe(_graphics),
        toolInfos=_maybe(_tool_infos),
    ),
    min_size=1,
    max_size=2,
)
_intervals = st.builds(
    pn.TimeInterval,
    earliest=NUMBERS,
    latest=_maybe(NUMBERS),
    earliestExcluded=st.booleans(),
    latestExcluded=st.booleans(),
)


@st.composite
def odd_models(draw: st.DrawFn) -> pn.Net:
    """Return a model with every kind of element, each with something odd here and there."""
    net = draw(st.sampled_from([pn.Net, sym.SystemModel]))(id="net")
    elements, places, transitions = _pages(draw, net)
    if isinstance(net, sym.SystemModel):
        elements += _channels(draw, net, places)
        net.tokenType = sym.TokenType(
            fields=[sym.TokenField(name=draw(TEXTS), default=draw(TEXTS), length=3)]
        )
        elements.append(net.tokenType)
    for number, element in enumerate(elements):
        element.id = f"e{number}"
    for element in [net, *draw(st.lists(st.sampled_from(elements), max_size=4, unique_by=id))]:
        _dress(draw, element)
    _clauses(draw, transitions)
    return net


def _dress(draw: st.DrawFn, element: pn.Element) -> None:
    element.name = draw(_maybe(TEXTS))
    element.graphics = draw(_maybe(_graphics))
    if draw(st.booleans()):
        element.labels.extend(draw(_labels))
    if draw(st.booleans()):
        element.toolInfos.extend(draw(_tool_infos))


def _pages(draw: st.DrawFn, net: pn.Net) -> tuple[list[pn.Element], list[pn.Place], list[pn.Transition]]:
    """Add a page inside a callback page inside a node net inside a page, all with nodes and arcs."""
    pages = [pn.Page(net=net), node_net := sym.NodeNet(), callback := sym.CallbackPage(), pn.Page()]
    for outer, inner in itertools.pairwise(pages):
        outer.objects.append(inner)
    group = sym.CallbackGroup(kind="reentrant", priority=-1)
    node_net.callbackGroups.append(group)
    node_net.signals.extend([sym.InputSignal(initial=True), sym.InputSignal()])
    callback.group = draw(st.sampled_from([None, group]))
    callback.timer = draw(_maybe(NUMBERS))
    elements: list[pn.Element] = [*pages, group, *node_net.signals]
    places: list[pn.Place] = []
    transitions: list[pn.Transition] = []
    for page in pages:
        place = _place(draw, page)
        kind = draw(st.sampled_from([None, "discrete", "timed", "start", "end"]))
        transition = sym.Transition(page=page, kind=kind) if kind else pn.Transition(page=page)
        transition.interval = draw(_maybe(_intervals))
        alias = pn.ReferencePlace(target=place, page=page)
        kind = draw(st.sampled_from(["normal", "read", "inhibitor"]))
        there = pn.Arc(source=place, target=transition, page=page, kind=kind)
        back = pn.Arc(source=transition, target=alias, page=page, weight=draw(st.integers(1, 2)))
        elements += [place, transition, alias, there, back]
        places.append(place)
        transitions.append(transition)
    transitions[0].overrides.extend(draw(st.lists(st.sampled_from(transitions), unique_by=id, max_size=3)))
    return elements, places, transitions


def _place(draw: st.DrawFn, page: pn.Page) -> pn.Place:
    tokens = draw(st.integers(0, 2))
    if draw(st.booleans()):
        return pn.Place(tokens=tokens, page=page)
    data = draw(st.lists(TEXTS, max_size=2))
    kind = draw(st.sampled_from(["ordinary", "start", "end"]))
    balloons = [sym.BalloonToken(data=text) for text in data]
    return sym.Place(tokens=tokens, page=page, kind=kind, balloons=balloons)


def _channels(draw: st.DrawFn, net: sym.SystemModel, places: list[pn.Place]) -> list[pn.Element]:
    """Add a topic and a service, in any order and on any page."""
    canvas = st.sampled_from([None, *(place.page for place in places)])
    topic = sym.TopicChannel(topic=draw(TEXTS), canvas=draw(canvas))
    topic.publishers.append(sym.PublisherPort(place=places[0], limit=-3))
    service = sym.ServiceChannel(service=draw(TEXTS), canvas=draw(canvas), instances=draw(_maybe(st.just(2))))
    if draw(st.booleans()):
        page = draw(st.sampled_from(places)).page
        service.server = sym.ServerPort(entry=places[1], exit=places[2], page=page)
    service.clients.append(sym.ClientPort(client=draw(TEXTS), request=places[2], response=places[3]))
    net.channels.extend(draw(st.permutations([topic, service])))
    return [topic, service]


def _clauses(draw: st.DrawFn, transitions: list[pn.Transition]) -> None:
    """Guard some transitions of the node net; sometimes the stored form is not the text's any more."""
    for transition in transitions[1:]:
        if not isinstance(transition, sym.Transition) or draw(st.booleans()):
            continue
        page = transitions[1].page
        assert isinstance(page, sym.NodeNet)
        for signal in page.signals:
            signal.name = None
        ids = [signal.id for signal in page.signals]
        text = draw(st.sampled_from(["{0}", "{0} and {1}", " !{1} ", "{0} | !{0}"])).format(*ids)
        clause = set_clause(transition, text, draw(_maybe(TEXTS)))
        clause.text = draw(st.sampled_from([text, text, ids[0], "("]))
