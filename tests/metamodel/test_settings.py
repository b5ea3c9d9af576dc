"""Changing models by text."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.base import features_of
from dineros.metamodel.errors import (
    ClauseError,
    DinerosError,
    FeatureValueError,
    UnknownElementError,
    UnknownFeatureError,
)
from dineros.metamodel.settings import SettingError, apply
from tests.support.systems.models import plain_nets, system_models


@pytest.fixture
def model() -> sym.SystemModel:
    """Two node nets, a topic, a service, a token type."""
    sorted_, place, sense = (
        sym.Place(id="SortRed"),
        sym.Place(id="Red", tokens=3),
        sym.Transition(id="TSense"),
    )
    place.balloons.extend([sym.BalloonToken(data="{}"), sym.BalloonToken(data="{}")])
    arc = pn.Arc(id="Red-TSense", source=place, target=sense)
    selector = sym.NodeNet(
        id="n1",
        name="selector",
        objects=[place, sense, sorted_],
        arcs=[arc],
        signals=[sym.InputSignal(id="Sensor"), sym.InputSignal(id="Danger")],
    )
    left, right = sym.Place(id="ReqControlL", name="Req"), sym.Place(id="ReqControlR", name="Req")
    callback = sym.CallbackPage(id="OnObject", objects=[left, right])
    entry, exit_ = sym.Place(id="PickEntry"), sym.Place(id="PickExit")
    server = sym.CallbackPage(id="PickServer", kind="server", objects=[entry, exit_])
    controller = sym.NodeNet(id="n2", name="controller", objects=[callback, server])
    topic = sym.TopicChannel(
        id="c1",
        topic="LeftCellObjects",
        publishers=[sym.PublisherPort(place=sorted_)],
        subscribers=[sym.SubscriberPort(place=left), sym.SubscriberPort(place=right)],
    )
    service = sym.ServiceChannel(
        id="c2",
        service="Pick",
        server=sym.ServerPort(entry=entry, exit=exit_, page=server),
        clients=[sym.ClientPort(client="picker", request=left, response=right)],
    )
    return sym.SystemModel(
        id="model",
        pages=[selector, controller],
        channels=[topic, service],
        tokenType=sym.TokenType(id="SortingToken", fields=[sym.TokenField(name="color")]),
    )


def reached(model: pn.Net, path: str) -> object:
    """Follow ids, features, and `[index]` of lists; independent of how settings find their way."""
    start, *steps = path.split("/")
    value: object = elements.find(model, start)
    for step in steps:
        value = value[int(step)] if step.isdigit() else getattr(value, step)  # type: ignore[index]
    return value


@pytest.mark.parametrize(
    ("setting", "path", "expected"),
    [
        ("Red.tokens=7", "Red/tokens", 7),
        ("Red.tokens= 7 ", "Red/tokens", 7),
        ("Red.name=two words = one", "Red/name", "two words = one"),
        ("Red-TSense.weight=4", "Red-TSense/weight", 4),
        ("Danger.initial=true", "Danger/initial", True),
        ("Danger.initial=False", "Danger/initial", False),
        ("selector.executor=multi", "n1/executor", sym.Executor.multi),
        ("n1.threads=3", "n1/threads", 3),
        ("OnObject.timer=0.5", "OnObject/timer", 0.5),
        ("Pick.instances=1", "c2/instances", 1),
        ("c2.instances=2", "c2/instances", 2),
        ("Pick.instances=", "c2/instances", None),
        ("c2.client.picker.outstanding=3", "c2/clients/0/outstanding", 3),
        ("TSense.kind=timed", "TSense/kind", sym.TransitionKind.timed),
        ("TSense.interval.latest=2.5", "TSense/interval/latest", 2.5),
        ("LeftCellObjects.publisher.SortRed.limit=5", "c1/publishers/0/limit", 5),
        ("LeftCellObjects.subscriber.ReqControlR.limit=3", "c1/subscribers/1/limit", 3),
        ("c1.dispatcher.controller.limit=8", "c1/dispatchers/0/limit", 8),
        ("c1.dispatcher.n2.limit=8", "c1/dispatchers/0/node/id", "n2"),
        ("c1.qos.reliability=bestEffort", "c1/qos/reliability", sym.Reliability.bestEffort),
        ("SortingToken.field.color.default=red", "SortingToken/fields/0/default", "red"),
        ("TSense.clause=Sensor & !Sensor", "TSense/clause/text", "Sensor & !Sensor"),
        ("Pick.client.picker.timeout=1.5", "c2/clients/0/timeout", 1.5),
        ("Pick.client.picker.group=calls", "n2/callbackGroups/0/id", "calls"),
        ("OnObject.group=calls", "OnObject/group/id", "calls"),
    ],
)
def test_changes_what_it_names(model: sym.SystemModel, setting: str, path: str, expected: object) -> None:
    apply(model, setting)
    assert reached(model, path) == expected


def test_changes_a_dispatcher_that_is_there(model: sym.SystemModel) -> None:
    apply(model, "c1.dispatcher.controller.limit=8")
    apply(model, "c1.dispatcher.controller.limit=9")
    channel = elements.find(model, "c1", sym.TopicChannel)
    assert [(found.node.id, found.limit) for found in channel.dispatchers] == [("n2", 9)]


def test_callback_groups_are_made_once_and_left(model: sym.SystemModel) -> None:
    for setting in ("OnObject.group=calls", "c2.client.picker.group= calls ", "calls.kind=reentrant"):
        apply(model, setting)
    (group,) = elements.find(model, "n2", sym.NodeNet).callbackGroups
    assert group.kind == sym.CallbackGroupKind.reentrant
    page, client = elements.find(model, "OnObject", sym.CallbackPage), reached(model, "c2/clients/0")
    assert isinstance(client, sym.ClientPort)
    assert page.group is client.group is group
    apply(model, "OnObject.group=")
    assert page.group is None


def test_an_empty_clause_removes_the_clause_and_its_uses(model: sym.SystemModel) -> None:
    apply(model, "TSense.clause=Sensor | Danger")
    apply(model, "TSense.clause=")
    assert elements.find(model, "TSense", sym.Transition).clause is None
    assert len(elements.find(model, "Sensor", sym.InputSignal).literals) == 0


def test_a_new_clause_keeps_the_name(model: sym.SystemModel) -> None:
    apply(model, "TSense.clause=Sensor")
    transition = elements.find(model, "TSense", sym.Transition)
    assert transition.clause is not None
    transition.clause.name = "may sense"
    apply(model, "TSense.clause=Danger")
    assert (transition.clause.name, transition.clause.text) == ("may sense", "Danger")


@pytest.mark.parametrize(("tokens", "left"), [(5, 2), (2, 2), (1, 1), (0, 0)])
def test_fewer_tokens_carry_less_data(model: sym.SystemModel, tokens: int, left: int) -> None:
    apply(model, f"Red.tokens={tokens}")
    assert len(elements.find(model, "Red", sym.Place).balloons) == left


def test_the_longest_name_is_meant() -> None:
    page = pn.Page(
        id="page", objects=[pn.Place(id="a"), pn.Place(id="a.b", name="a.b.c"), pn.Place(id="x=y")]
    )
    net = pn.Net(id="net", pages=[page])
    for setting in ("a.tokens=1", "a.b.tokens=2", "a.b.c.name=d", "x=y.tokens=4"):
        apply(net, setting)
    assert [(place.tokens, place.name) for place in elements.places(net)] == [(1, None), (2, "d"), (4, None)]


def test_an_id_goes_before_a_name() -> None:
    page = pn.Page(id="page", objects=[pn.Place(id="p1", name="p2"), pn.Place(id="p2")])
    net = pn.Net(id="net", pages=[page])
    apply(net, "p2.tokens=1")
    assert [place.tokens for place in elements.places(net)] == [0, 1]


def test_a_reference_with_the_name_of_its_place_is_not_meant() -> None:
    place = pn.Place(id="p1", name="Ready")
    reference = pn.ReferencePlace(id="r1", name="Ready", target=place)
    net = pn.Net(id="net", pages=[pn.Page(id="page", objects=[reference, place])])
    apply(net, "Ready.tokens=1")
    assert place.tokens == 1


@pytest.mark.parametrize(
    ("setting", "error", "part"),
    [
        ("", SettingError, "ELEMENT.FEATURE=VALUE"),
        ("Red", SettingError, "ELEMENT.FEATURE=VALUE"),
        ("Red=2", SettingError, "ELEMENT.FEATURE=VALUE"),
        ("Red.tokens", SettingError, "ELEMENT.FEATURE=VALUE"),
        ("Red=2.5", SettingError, "ELEMENT.FEATURE=VALUE"),
        (".tokens=2", SettingError, "ELEMENT.FEATURE=VALUE"),
        ("Rad.tokens=2", UnknownElementError, "did you mean 'Red'"),
        ("Req.tokens=2", UnknownElementError, "'ReqControlL' or 'ReqControlR'"),
        ("LeftCelObjects.publisher.SortRed.limit=2", UnknownElementError, "did you mean 'LeftCellObjects'"),
        ("c1.publisher.SortRad.limit=2", UnknownElementError, "did you mean 'SortRed'"),
        ("c1.publisher.zzz.limit=2", UnknownElementError, "known here: SortRed"),
        ("c1.subscriber.Req.limit=2", UnknownElementError, "use an id"),
        ("c1.dispatcher.selector.limit=2", UnknownElementError, "known here: controller, n2"),
        ("Red.tokns=2", UnknownFeatureError, "did you mean 'tokens'"),
        ("Red.clause=Sensor", UnknownFeatureError, "is not a feature of a Place"),
        ("Red.qos.reliability=reliable", UnknownFeatureError, "is not a feature of a Place"),
        ("Red.publisher.SortRed.limit=2", UnknownFeatureError, "is not a feature of a Place"),
        ("Red.id=Blue", UnknownFeatureError, "'id' cannot be set"),
        ("Red.page=n1", UnknownFeatureError, "'page' cannot be set"),
        ("c1.publishers=2", UnknownFeatureError, "'publishers' cannot be set"),
        ("c1.publisher.SortRed.place=2", UnknownFeatureError, "'place' cannot be set"),
        ("c1.publisher.SortRed=2", UnknownElementError, "there is no publisher ''"),
        ("Red.tokens=two", FeatureValueError, "takes a whole number, not 'two'"),
        ("Red.tokens=2.0", FeatureValueError, "takes a whole number"),
        ("Red.tokens=1_000", FeatureValueError, "takes a whole number"),
        ("Red.tokens=", FeatureValueError, "takes a whole number"),
        ("Red.tokens=" + "9" * 5000, FeatureValueError, "takes a whole number"),
        ("TSense.interval.latest=inf", FeatureValueError, "takes a number"),
        ("Danger.initial=yes", FeatureValueError, "takes true or false"),
        ("selector.executor=multy", FeatureValueError, "did you mean 'multi'"),
        ("TSense.clause=Sensor &", ClauseError, ""),
        ("OnObject.group=Red", FeatureValueError, "'Red' is a Place that is not one of them"),
        ("Red.group=calls", UnknownFeatureError, "is not a feature of a Place"),
        ("Pick.client.pick.group=calls", UnknownElementError, "did you mean 'picker'"),
        ("TSense.clause=Sensr", ClauseError, "Sensor"),
    ],
)
def test_refuses_in_one_line(
    model: sym.SystemModel, setting: str, error: type[DinerosError], part: str
) -> None:
    with pytest.raises(error) as caught:
        apply(model, setting)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 250


def test_a_refused_setting_makes_nothing(model: sym.SystemModel) -> None:
    for setting in ("c1.dispatcher.n2.limit=x", "c1.qos.reliability=x", "TSense.interval.latest=x"):
        with pytest.raises(FeatureValueError):
            apply(model, setting)
    channel = elements.find(model, "c1", sym.TopicChannel)
    assert len(channel.dispatchers) == 0
    assert channel.qos is None
    assert elements.find(model, "TSense", sym.Transition).interval is None


@given(st.data(), st.one_of(plain_nets(), system_models()))
def test_every_id_of_every_model_can_be_addressed(data: st.DataObject, net: pn.Net) -> None:
    element = data.draw(st.sampled_from(list(elements.elements(net))))
    name = data.draw(st.text(min_size=1).map(str.strip).filter(bool))
    before = {other.id: other.name for other in elements.elements(net)}
    apply(net, f"{element.id}.name={name}")
    assert {other.id: other.name for other in elements.elements(net)} == {**before, element.id: name}


@pytest.mark.long
@given(plain_nets(), st.text(), st.text())
def test_any_text_is_applied_or_refused(net: pn.Net, path: str, value: str) -> None:
    place = elements.places(net)[0]
    for setting in (path, f"{path}={value}", f"{place.id}.{path}={value}", f"{place.id}.tokens={value}"):
        try:
            apply(net, setting)
        except DinerosError as error:
            assert "\n" not in str(error)


@given(plain_nets(), st.integers(0, 10**12))
def test_only_the_named_attribute_changes(net: pn.Net, tokens: int) -> None:
    place = elements.places(net)[-1]
    before = _attributes(net)
    apply(net, f"{place.id}.tokens={tokens}")
    after = _attributes(net)
    assert after == {**before, (place.id, "tokens"): tokens}


def _attributes(net: pn.Net) -> dict[tuple[str, str], object]:
    return {
        (element.id, name): getattr(element, name)
        for element in elements.elements(net)
        for name, feature in features_of(type(element)).items()
        if feature.eClass.name == "EAttribute"
    }


def test_properties_and_assumptions_can_be_changed() -> None:
    model = sym.SystemModel(id="model")
    model.properties.append(sym.Property(id="calm.one", name="calm", text="never A >= 1"))
    model.assumptions.append(sym.Fairness(id="fair", of="all"))
    apply(model, "calm.one.text=never A >= 2")
    apply(model, "calm.expected=false")
    apply(model, "fair.strong=true")
    (calm,), (fair,) = model.properties, model.assumptions
    assert (calm.text, calm.expected) == ("never A >= 2", False)
    assert isinstance(fair, sym.Fairness)
    assert fair.strong
    with pytest.raises(UnknownElementError, match="calm"):
        apply(model, "clam.text=never A >= 1")


def test_an_action_is_found_by_its_name() -> None:
    model = sym.SystemModel(id="model", channels=[sym.ActionChannel(id="Delivery", action="/deliver")])
    apply(model, "/deliver.depth=3")
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    assert channel.depth == 3


def test_the_hint_names_what_of_a_part_can_be_set() -> None:
    model = sym.SystemModel(id="robot", pages=[sym.NodeNet(id="listener")])
    with pytest.raises(UnknownFeatureError) as refused:
        apply(model, "listener.reaction=0.1")
    assert "set reaction.earliest or reaction.latest" in str(refused.value)
