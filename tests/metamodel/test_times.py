"""What a system model says of time: durations, offsets, jitter, latencies, reactions, orders and defaults."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.exact import exact_number, fraction_of
from dineros.metamodel.settings import apply
from tests.support.equality import differences
from tests.support.systems.small import small_system


def timed_system() -> sym.SystemModel:
    """Return a model that says everything of time that there is."""
    model = small_system()
    model.times = sym.DefaultTimes(
        latency=seconds(0, 0.01), duration=seconds(0.001, 0.002), reaction=seconds(0, 0)
    )
    model.middleware = sym.Middleware.ros2
    node = node_net(model, "beat", execution="callbacks", order="rclpy")
    callback(
        node, "on_beat", "timer", 0.1, duration=seconds(0.03, None), offset=seconds(0, 0.05), jitter=0.004
    )
    place(node, "rest", 1)
    for channel in model.channels:
        channel.latency = pn.TimeInterval(earliest=0.001, latest=0.2, latestExcluded=True)
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            channel.publishers[0].latency = seconds(0.5, 1)
            channel.subscribers[0].latency = seconds(0, exact_number("0.10000000000000000001"))
        elif isinstance(channel, sym.ServiceChannel):
            channel.clients[0].latency = seconds(0, 3)
    for net in model.pages:
        if isinstance(net, sym.NodeNet) and net is not node:
            net.reaction = seconds(0, 0.25)
    return model


@pytest.mark.parametrize("suffix", [".sym.xmi", ".pnml"])
def test_times_survive_files(tmp_path: Path, suffix: str) -> None:
    model = timed_system()
    save(model, tmp_path / f"model{suffix}")
    again = load(tmp_path / f"model{suffix}")
    assert differences(again, model) == []
    assert isinstance(again, sym.SystemModel) and isinstance(again.channels[0], sym.TopicChannel)
    latency = again.channels[0].subscribers[0].latency
    assert latency is not None and latency.latest is not None
    assert fraction_of(latency.latest) == fraction_of(exact_number("0.10000000000000000001"))


def test_settings_make_times_where_they_are_absent() -> None:
    model = timed_system()
    node = find(model, "beat", sym.NodeNet)
    page = find(model, "on_beat", sym.CallbackPage)
    page.duration, page.offset = None, None
    bare = small_system()
    model.times = bare.times
    topic = next(each for each in model.channels if isinstance(each, sym.TopicChannel))
    topic.latency, topic.subscribers[0].latency = None, None
    for setting in (
        "on_beat.duration.earliest=0.01",
        "on_beat.duration.latest=1/30",
        "on_beat.offset.latest=0",
        "on_beat.jitter=0.002",
        "beat.order=rclcpp",
        "times.latency.latest=0.02",
        f"{topic.id}.latency.latest=0.125",
        f"{topic.id}.subscriber.{topic.subscribers[0].place.id}.latency.latest=2.5",
    ):
        apply(model, setting)
    page = find(model, "on_beat", sym.CallbackPage)
    assert (str(node.order), page.jitter) == ("rclcpp", 0.002)
    assert page.duration is not None and page.duration.latest is not None
    assert (page.duration.earliest, str(page.duration.latest)) == (0.01, "1/30")
    assert page.offset is not None and page.offset.latest == 0
    defaults = model.times
    assert defaults is not None and defaults.latency is not None and defaults.latency.latest == 0.02
    topic = next(each for each in model.channels if isinstance(each, sym.TopicChannel))
    assert topic.latency is not None and topic.latency.latest == 0.125
    latency = topic.subscribers[0].latency
    assert latency is not None and latency.latest == 2.5


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("on_beat.duration.latest=soon", "takes a number"),
        ("on_beat.duration.latest=nan", "takes a number"),
        ("on_beat.durations.latest=1", "is not a feature"),
        ("beat.order=fifo", "order"),
        ("times.latency.most=1", "'most' is not a feature"),
    ],
)
def test_settings_that_say_no_time(setting: str, message: str) -> None:
    with pytest.raises(DinerosError, match=message):
        apply(timed_system(), setting)


def test_defaults_of_a_plain_net_are_refused() -> None:
    with pytest.raises(DinerosError, match="the model is not a system model"):
        apply(pn.Net(id="n"), "times.latency.latest=1")


def test_times_change_no_net_without_time() -> None:
    from dineros.metamodel.files.tina import net_text
    from dineros.transformations.flattening.flatten import flatten

    timed, plain = timed_system(), timed_system()
    plain.times = None
    for element in plain.eAllContents():
        for feature in ("duration", "offset", "jitter", "latency", "reaction"):
            if getattr(element, feature, None) is not None:
                setattr(element, feature, None)
    find(plain, "beat", sym.NodeNet).order = sym.CallbackOrder.any
    assert net_text(flatten(timed).net) == net_text(flatten(plain).net)


def test_a_model_with_times_of_all_kinds_has_nothing_wrong_about_them() -> None:
    about = {"duration", "offset", "jitter", "reaction", "order", "interval"}
    assert [v for v in validate(timed_system()) if about & set(v.constraint.split("-"))] == []
