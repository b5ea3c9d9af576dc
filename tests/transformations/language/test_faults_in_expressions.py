"""Faults in the expressions, pattern nodes and elements of a rule are found when its module is imported."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.rule_faults import RULE, Faults, check

FAULTS: Faults = {
    "misspelt feature of a pattern node's value": (
        RULE.format("limit = either(port.limmit, 3)  #!"),
        "PublisherPort has no feature 'limmit'",
        "did you mean 'limit'?",
    ),
    "misspelt feature in a chain": (
        RULE.format("far = Node(pn.Page, of=port.place.pagee)  #!"),
        "Place has no feature 'pagee'",
        "did you mean 'page'?",
    ),
    "feature of a plain value": (RULE.format("far = port.limit.page  #!"), "is not a model element", ""),
    "misspelt feature in a pattern node": (
        RULE.format("other = Node(sym.TopicChannel, topik='x')  #!"),
        "TopicChannel has no feature 'topik'",
        "did you mean 'topic'?",
    ),
    "misspelt feature of a new element": (
        RULE.format("watch = New(pn.Place, page=SHEET, id='watch', token=1)  #!"),
        "Place has no feature 'token'",
        "did you mean 'tokens'?",
    ),
    "misspelt feature in a condition of count": (
        RULE.format("many = count(channel.publishers, lambda port: port.limitt > 3)  #!"),
        "PublisherPort has no feature 'limitt'",
        "did you mean 'limit'?",
    ),
    "misspelt feature in first": (
        RULE.format("one = first(channel.dispatchers, nodee=3)  #!"),
        "Dispatcher has no feature 'nodee'",
        "did you mean 'node'?",
    ),
    "misspelt feature on the second line of a call": (
        RULE.format(
            "queue = OverflowQueue(\n        'q',\n        source=source, limit=port.limits,  #!\n    )"
        ),
        "PublisherPort has no feature 'limits'",
        "did you mean 'limit'?",
    ),
    "element of the wrong class in a new element": (
        RULE.format("watch = place('watch')\n    joint = arc(channel, watch)  #!"),
        "Arc.source needs Node, not TopicChannel",
        "",
    ),
    "element of the wrong class in a pattern node": (
        RULE.format("other = Node(sym.PublisherPort, place=channel)  #!"),
        "place needs Place, not TopicChannel",
        "",
    ),
    "of with a value of another class": (
        RULE.format("other = Node(pn.Transition, of=port.place)  #!"),
        "of needs Transition, not PublisherPort.place (Place)",
        "",
    ),
    "of with a plain value": (
        RULE.format("other = Node(pn.Place, of=port.limit)  #!"),
        "of needs Place, not PublisherPort.limit (a plain value)",
        "",
    ),
    "number for a reference of a new element": (
        RULE.format("joint = New(pn.Arc, page=SHEET, id='a', source=3, target=source)  #!"),
        "Arc.source needs Node, not 3 (a plain value)",
        "",
    ),
    "number for a reference of a pattern node": (
        RULE.format("other = Node(sym.PublisherPort, channel=3)  #!"),
        "PublisherPort.channel cannot equal 3",
        "",
    ),
    "element for an attribute of a new element": (
        RULE.format("watch = place('watch', tokens=channel)  #!"),
        "Place.tokens takes EInt, not an element: TopicChannel",
        "",
    ),
    "element for an attribute of a pattern node": (
        RULE.format("other = Node(pn.Place, tokens=channel)  #!"),
        "Place.tokens cannot equal TopicChannel",
        "",
    ),
    "text for a number of a new element": (
        RULE.format("watch = place('watch', tokens='many')  #!"),
        "Place.tokens takes EInt, not many",
        "",
    ),
    "text feature for a number of a new element": (
        RULE.format("watch = place('watch', tokens=channel.topic)  #!"),
        "Place.tokens takes EInt, not TopicChannel.topic",
        "",
    ),
    "truth value for a number of a new element": (
        RULE.format("watch = place('watch', tokens=port.limit == 3)  #!"),
        "Place.tokens takes EInt, not PublisherPort.limit == 3",
        "",
    ),
    "text for a number of a pattern node": (
        RULE.format("other = Node(pn.Place, tokens='three')  #!"),
        "Place.tokens cannot equal three",
        "",
    ),
    "list for a single reference of a new element": (
        RULE.format("joint = arc(channel.publishers.place, T1.transport)  #!"),
        "Arc.source takes a single value, but TopicChannel.publishers.place is a list",
        "",
    ),
    "list for a feature of a pattern node": (
        RULE.format("other = Node(sym.PublisherPort, place=channel.publishers.place)  #!"),
        "PublisherPort.place cannot equal TopicChannel.publishers.place",
        "",
    ),
    "single element for a list of a new element": (
        RULE.format("other = New(pn.Transition, page=SHEET, id='x', overrides=T1.transport)  #!"),
        "Transition.overrides takes a list, but transport is a single value",
        "",
    ),
    "comparison of an element with a number": (
        RULE.format("where = [port.place == 3]  #!"),
        "PublisherPort.place == 3 compares values that can never be equal",
        "",
    ),
    "comparison of elements of unrelated classes": (
        RULE.format("where = [port.place == channel]  #!"),
        "compares values that can never be equal",
        "",
    ),
    "comparison of a number with a text": (
        RULE.format("where = [port.limit == 'three']  #!"),
        "compares values that can never be equal",
        "",
    ),
    "order of elements": (
        RULE.format("where = [port < channel]  #!"),
        "compares values that can never be equal",
        "",
    ),
    "other kind of default": (
        RULE.format("limit = either(port.limit, 'three')  #!"),
        "three is not a value that PublisherPort.limit can have",
        "",
    ),
    "counting a single value": (RULE.format("many = count(port.place)  #!"), "cannot be counted", ""),
    "first of a single value": (RULE.format("one = first(port.place)  #!"), "has no first element", ""),
    "counting up to a text": (
        RULE.format("step = Index(upto=channel.topic)  #!"),
        "not a number to count up to",
        "",
    ),
    "missing container": (
        RULE.format("watch = New(pn.Place, id='watch')  #!"),
        "missing container: a new Place needs page",
        "",
    ),
    "missing container of a class without a feature for it": (
        RULE.format("watch = New(sym.QualityOfService)  #!"),
        "missing container: a new QualityOfService needs into=",
        "",
    ),
    "missing required feature": (
        RULE.format("joint = New(pn.Arc, page=SHEET, id='a', source=source)  #!"),
        "Arc needs target",
        "required by the metamodel",
    ),
    "abstract class": (
        RULE.format("watch = New(pn.Node, page=SHEET, id='watch')  #!"),
        "Node is abstract and cannot be created",
        "",
    ),
    "into that is not a list": (
        RULE.format("twin = Copy(source, into=source.page, named=pn.Element, id='x')  #!"),
        "Place.page is not a many-valued containment feature",
        "",
    ),
    "into that contains nothing": (
        RULE.format("watch = New(pn.Transition, id='w', into=port.place.incoming)  #!"),
        "PublisherPort.place.incoming is not a containment feature of one element",
        "",
    ),
    "into of many elements": (
        RULE.format(
            "watch = New(sym.PublisherPort, place=source, into=channel.publishers.channel.publishers)  #!"
        ),
        "is not a containment feature of one element",
        "",
    ),
    "into of another class": (
        RULE.format("watch = New(pn.Place, id='w', into=channel.publishers)  #!"),
        "into needs Place, not TopicChannel.publishers (PublisherPort)",
        "",
    ),
    "copy into a list of another class": (
        RULE.format("twin = Copy(source, into=channel.publishers, named=pn.Element, id='x')  #!"),
        "into needs Place, not TopicChannel.publishers (PublisherPort)",
        "",
    ),
    "copy that names what has no id": (
        RULE.format("twin = Copy(source, into=source.page.objects, named=sym.QualityOfService, id='x')  #!"),
        "QualityOfService has no feature 'id'",
        "",
    ),
    "misspelt literal in a new element": (
        RULE.format(
            "joint = New(pn.Arc, page=SHEET, id='a', source=source, target=T1.transport, kind='inhibitr')  #!"
        ),
        "ArcKind has no literal 'inhibitr'",
        "did you mean 'inhibitor'?",
    ),
    "misspelt literal in a pattern node": (
        RULE.format("joint = Node(pn.Arc, kind='inhibitr')  #!"),
        "ArcKind has no literal 'inhibitr'",
        "did you mean 'inhibitor'?",
    ),
    "misspelt literal in a condition": (
        RULE.format("joint = Node(pn.Arc)\n    where = [joint.kind == 'raed']  #!"),
        "ArcKind has no literal 'raed'",
        "did you mean 'read'?",
    ),
    "literal of another enumeration": (
        RULE.format("joint = Node(pn.Arc)\n    where = [joint.kind == sym.PlaceKind.start]  #!"),
        "compares values that can never be equal",
        "",
    ),
    "lookup of a misspelt role": (
        RULE.format("topic = Made(T1.topik, of=channel)  #!"),
        "dangling lookup: T1 has no 'topik'",
        "did you mean 'topic'?",
    ),
    "lookup of a role of no rule": (
        "loose = place('loose')\n" + RULE.format("topic = Made(loose, of=channel)  #!"),
        "no rule creates Place",
        "",
    ),
    "lookup of a model class": (
        RULE.format("topic = Made(pn.Place, of=channel)  #!"),
        "no rule creates",
        "",
    ),
    "lookup by what the maker never matches": (
        RULE.format("topic = Made(T1.topic, of=port)  #!"),
        "dangling lookup: T1 matches no PublisherPort",
        "",
    ),
    "lookup by one thing too many": (
        RULE.format("topic = Made(T1.topic, of=[channel, port])  #!"),
        "dangling lookup: T1 matches no PublisherPort",
        "",
    ),
    "lookup by what the maker only looks up": (
        RULE.format("topic = Made(T1.topic, of=channel)\n    queue = Made(T3.queue, of=topic)  #!"),
        "dangling lookup: T3 matches no Place",
        "",
    ),
    "lookup by a number where the maker counts nothing": (
        RULE.format("topic = Made(T1.topic, of=[channel, Index(upto=3)])  #!"),
        "dangling lookup: T1 matches no number",
        "",
    ),
    "misspelt member of a group": (
        RULE.format("queue = Made(OverflowQueue)\n    bad = queue.laod  #!"),
        "dangling lookup: OverflowQueue has no 'laod'",
        "did you mean 'load'?",
    ),
    "malformed placeholder": (
        RULE.format("watch = place('{channel.id')  #!").replace("[*lhs]", "[*lhs, watch]"),
        "bad text '{channel.id'",
        "",
    ),
    "placeholder without a name": (
        RULE.format("watch = place('{}.watch')  #!"),
        "placeholder {} is not an element of the rule",
        "known:",
    ),
    "unknown name in a placeholder": (
        RULE.format("watch = place('{chanel.id}.watch')  #!"),
        "placeholder {chanel.id} is not an element of the rule",
        "did you mean 'channel'?",
    ),
    "unknown feature in a placeholder": (
        RULE.format("watch = place('{channel.ident}.watch')  #!"),
        "TopicChannel has no feature 'ident'",
        "",
    ),
    "feature of a plain value in a placeholder": (
        RULE.format("watch = place('{channel.id.size}.watch')  #!"),
        "has no 'size'",
        "",
    ),
    "unknown name in the id of a copy": (
        RULE.format("twin = Copy(source, into=source.page.objects, named=pn.Element, id='{originl.id}')  #!"),
        "placeholder {originl.id} is not an element of the rule",
        "did you mean 'original'?",
    ),
    "unknown name in the id of a group": (
        RULE.format("queue = OverflowQueue('{prt.id}', source=source, limit=port.limit)  #!").replace(
            "[*lhs]", "[*lhs, *queue]"
        ),
        "placeholder {prt.id} is not an element of the rule",
        "did you mean 'port'?",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_reported_with_its_line(fault: str, tmp_path: Path) -> None:
    check(FAULTS[fault], tmp_path / "my_rules.py")
