"""What was seen becomes a valid model, which says the same of nodes and ports, and whose nets are bounded."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from dineros.analysis.checks.check import check
from dineros.cli.main import main
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find, node_nets
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load, save
from dineros.metamodel.matching import Quality
from dineros.observation.differences.comparing import differences
from dineros.observation.differences.described import described
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given
from dineros.observation.importing.given_reading import read_given
from dineros.observation.systems import (
    USUAL,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    RecordedService,
    RecordedTopic,
    TopicEndpoint,
)
from tests.support.ros2_systems.blocking_callbacks import some_waits_for_ever
from tests.support.systems.foreign import FOREIGN, TEXT, TRIGGER, port, robot, trigger

QUALITIES = st.builds(
    Quality,
    st.sampled_from(["reliable", "bestEffort"]),
    st.sampled_from(["volatile", "transientLocal"]),
    st.sampled_from(["automatic", "manualByTopic"]),
    st.none() | st.sampled_from([0.1, 2.5]),
    st.none() | st.sampled_from([1.0]),
    st.none() | st.sampled_from([3.0]),
)
NAMES = ["/a", "/b", "/a/c", "/a_c", "/observed"]


COMMANDER = """
[node."/commander"]
timers.tick = 1
callback.tick.does = ["send /plan ?"]
callback."/plan".does = []
"""


def errors(model: sym.SystemModel) -> list[str]:
    return [violation.message for violation in validate(model) if violation.severity == "error"]


@st.composite
def systems(draw: st.DrawFn) -> ObservedSystem:
    """Systems in which each name has one type and each service one server at most."""
    served: set[tuple[str, str]] = set()

    def topics() -> tuple[TopicEndpoint, ...]:
        depths = st.none() | st.integers(0, 20)
        names = draw(st.lists(st.sampled_from(NAMES), max_size=3))
        return tuple(port(name, TEXT, draw(QUALITIES), draw(depths)) for name in names)

    def endpoints(role: str, type: str) -> tuple[Endpoint, ...]:
        names = draw(st.lists(st.sampled_from(NAMES), max_size=2, unique=True))
        if role == "servers":
            names = [name for name in names if (type, name) not in served]
            served.update((type, name) for name in names)
        return tuple(Endpoint(name, type) for name in names)

    nodes = [
        ObservedNode(
            name,
            topics(),
            topics(),
            endpoints("servers", TRIGGER),
            endpoints("clients", TRIGGER),
            endpoints("servers", "nav/action/Go"),
            endpoints("clients", "nav/action/Go"),
            draw(st.none() | st.booleans()),
        )
        for name in draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True))
    ]
    return ObservedSystem("nowhere", tuple(sorted(nodes, key=lambda node: node.name)))


@pytest.mark.long
@settings(max_examples=30, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(systems())
def test_whatever_was_seen_makes_a_valid_model_that_says_the_same(system: ObservedSystem) -> None:
    imported = to_model(system)
    assert errors(imported.model) == []
    assert imported.left_out == ()
    report = differences(imported.model, system)
    assert report.findings == []
    assert len(report.proved) == len(system.nodes)


@pytest.mark.long
@settings(max_examples=30, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(systems(), st.data())
def test_what_is_otherwise_is_found(system: ObservedSystem, data: st.DataObject) -> None:
    """The other way round: of a model, one thing is taken away from what was seen."""
    model = to_model(system).model
    node = data.draw(st.sampled_from(system.nodes))
    roles = [name for name in ("publishers", "subscribers", "servers", "clients") if getattr(node, name)]
    if not roles:
        changed = tuple(each for each in system.nodes if each is not node)
    else:
        ports: dict[str, Any] = {role: getattr(node, role)[1:] for role in roles[:1]}
        changed = tuple(replace(node, **ports) if each is node else each for each in system.nodes)
    found = differences(model, replace(system, nodes=changed)).findings
    assert found
    assert {finding.rule for finding in found} <= {"node-missing", "port-missing", "quality-differs"}


def test_the_robot_is_what_its_programs_say(tmp_path: Path) -> None:
    imported = to_model(robot(), id="robot")
    assert errors(imported.model) == []
    assert len(node_nets(imported.model)) == 12
    for suffix in ("sym.xmi", "pnml"):
        save(imported.model, tmp_path / f"robot.{suffix}")
        read = load(tmp_path / f"robot.{suffix}")
        assert isinstance(read, sym.SystemModel)
        assert described(read) == described(imported.model)
    assert {node.name for node in described(imported.model).system.nodes} == {
        node.name for node in robot().nodes
    }


def test_what_nobody_told_is_marked_and_listed() -> None:
    seen = (ObservedNode("/talker", publishers=(port("/talk", depth=3), port("/news"))),)
    imported = to_model(ObservedSystem("nowhere", seen))
    assert [each.key for each in imported.assumed] == [
        'depths."/news"' if key == "depths" else key
        for key in ("depths", "timers", 'callback."timer".does', "threads")
    ]
    (node,) = node_nets(imported.model)
    assert node.assumed == "timers executor"
    talk, news = (find(imported.model, f"topic.{name}", sym.TopicChannel) for name in ("talk", "news"))
    assert (talk.publishers[0].limit, talk.publishers[0].assumed) == (3, None)
    assert (news.publishers[0].limit, news.publishers[0].assumed) == (10, "limit")


LATCHED = USUAL._replace(durability="transientLocal")


@pytest.mark.parametrize(
    ("quality", "depth", "given", "newest", "assumed"),
    [
        (USUAL, 1, "", True, "newestOnly"),
        (USUAL, 2, "", False, None),
        (USUAL, 2, 'newest."/x" = true', True, None),
        (USUAL, 5, 'depths."/x" = 1', True, "newestOnly"),
        (LATCHED, 10, "", True, "newestOnly"),
        (LATCHED, 10, 'newest."/x" = false', False, None),
    ],
)
def test_a_reader_that_needs_the_newest_only_is_assumed_by_its_quality(
    quality: Quality, depth: int, given: str, newest: bool, assumed: str | None
) -> None:
    seen = (
        ObservedNode("/a", publishers=(TopicEndpoint("/x", TEXT, quality, 10),)),
        ObservedNode("/b", subscribers=(TopicEndpoint("/x", TEXT, quality, depth),)),
    )
    imported = to_model(ObservedSystem("nowhere", seen), read(f'[node."/b"]\n{given}\n'))
    (reader,) = find(imported.model, "topic.x", sym.TopicChannel).subscribers
    assert (reader.newestOnly, reader.assumed) == (newest, assumed)
    listed = [each.words for each in imported.assumed if each.key == 'newest."/x"']
    assert listed == (["needs only the newest message of /x"] if assumed else [])


def test_all_kept_is_no_guess() -> None:
    seen = (ObservedNode("/talker", publishers=(port("/talk", depth=0),)),)
    imported = to_model(ObservedSystem("nowhere", seen))
    channel = find(imported.model, "topic.talk", sym.TopicChannel)
    assert (channel.publishers[0].limit, channel.publishers[0].assumed) == (5000, None)


@pytest.mark.long
def test_open_behaviour_is_bounded_by_histories(tmp_path: Path) -> None:
    """Any callback may publish any number of times; the markings are finite all the same."""
    nodes = (
        ObservedNode("/a", publishers=(port("/x", depth=1),)),
        ObservedNode("/b", subscribers=(port("/x", depth=1),), publishers=(port("/y", depth=1),)),
    )
    save(to_model(ObservedSystem("nowhere", nodes)).model, tmp_path / "open.sym.xmi")
    result = CliRunner().invoke(main, ["statespace", str(tmp_path / "open.sym.xmi"), "--json"])
    assert result.exit_code == 0, result.output
    assert "unbounded" not in result.output


def test_a_call_inside_a_callback_of_one_thread_waits_for_ever() -> None:
    """The differential way: by the interpreter of system models, not by rules and engines."""
    nodes = (
        ObservedNode("/planner", servers=(trigger("/plan"),), clients=(trigger("/where"),)),
        ObservedNode("/localizer", servers=(trigger("/where"),)),
        ObservedNode("/commander", clients=(trigger("/plan"),)),
    )
    system = ObservedSystem("nowhere", nodes)
    said = read('[node."/planner"]\ntimers = {}\ncallback."/plan".does = ["call /where"]\n' + COMMANDER)
    assert some_waits_for_ever(_one_request_each(to_model(system, said).model))
    fixed = read(
        '[node."/planner"]\nthreads = 2\ntimers = {}\ngroups = {others = "exclusive"}\n'
        'callback."/plan" = {does = ["call /where"], group = "others"}\n' + COMMANDER
    )
    assert not some_waits_for_ever(_one_request_each(to_model(system, fixed).model))


def _one_request_each(model: sym.SystemModel) -> sym.SystemModel:
    for channel in model.channels:
        if isinstance(channel, sym.ServiceChannel):
            for client in channel.clients:
                client.outstanding = client.request.capacity = 1  # so that there are few states
    return model


SENDING = """
[node."/user"]
timers.tick = 0.02
callback.tick.does = ["send /move"]
callback."/move".does = []
[node."/mover"]
timers = {}
"""


@pytest.mark.long
def test_a_request_that_no_callback_waits_for_may_be_lost_and_is_never_held_up() -> None:
    """Sending ends whatever the server does, and a node that was not seen is no cause of a finding."""
    user = ObservedNode("/user", clients=(trigger("/move"),))
    mover = ObservedNode("/mover", servers=(trigger("/move"),), clients=(trigger("/never"),))
    said = read(SENDING + 'callback."/move".does = []\n')
    report = check(to_model(ObservedSystem("pile", (user, mover)), said).model)
    lost = "request history of service /move can overflow: a request is lost"
    assert lost in [each.message for each in report.findings]
    assert not any(each.rule.startswith("callback-") for each in report.findings)

    said = read(SENDING + 'callback."/move".does = ["call /never"]\n')
    report = check(to_model(ObservedSystem("send", (user, mover)), said).model)
    stuck = [each.message for each in report.findings if each.rule.startswith("callback-")]
    assert stuck == ["service callback mover.serves_move (instance 1) can begin and never end"]
    returns = [each.message for each in report.findings if each.rule == "service-never-returns"]
    assert "service /never never returns: no node was seen that serves it" in returns


@pytest.mark.long
def test_an_open_callback_may_send_without_waiting() -> None:
    user = ObservedNode("/user", clients=(trigger("/move"),))
    mover = ObservedNode("/mover", servers=(trigger("/move"),))
    imported = to_model(ObservedSystem("open", (user, mover)))
    (value,) = (each.value for each in imported.assumed if each.key == 'callback."timer".does')
    assert value == '["send /move *", "call /move *"]'
    report = check(imported.model)
    assert "request history of service /move can overflow: a request is lost" in [
        each.message for each in report.findings
    ]


def read(text: str) -> Given:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.given.toml"
        path.write_text(text)
        return read_given(path)


def test_what_is_given_of_the_robot_leaves_open_only_threads_of_sensors_and_readers_of_the_newest() -> None:
    imported = to_model(robot(), read_given(FOREIGN / "robot.given.toml"), "robot")
    assert errors(imported.model) == []
    assert {each.kind for each in imported.assumed} <= {"threads", "newest"}
    assert imported.unused == ()


def test_what_a_model_cannot_hold_is_left_out_in_a_line_each() -> None:
    nodes = (
        ObservedNode(
            "/a", publishers=(port("/x"), port("no name"), port("/z", "??")), servers=(trigger("/s"),)
        ),
        ObservedNode("/b", subscribers=(port("/x", "std_msgs/msg/Int32"),), servers=(trigger("/s"),)),
        ObservedNode("not a name" + " and more" * 1000),
    )
    imported = to_model(ObservedSystem("nowhere", nodes))
    assert errors(imported.model) == []
    assert len(imported.left_out) == 5
    assert all("\n" not in line and len(line) < 300 for line in imported.left_out)


def test_a_service_that_nobody_serves_never_answers() -> None:
    system = ObservedSystem("nowhere", (ObservedNode("/a", clients=(trigger("/s"),)),))
    imported = to_model(system)
    assert imported.unseen == ("/unseen/server/s",)
    assert some_waits_for_ever(imported.model)
    assert differences(imported.model, system).findings == []


def test_topics_of_a_recording_have_a_node_each_that_nobody_has_seen_unless_it_is_given() -> None:
    topics = (RecordedTopic("/x", TEXT, (USUAL,)), RecordedTopic("/y", TEXT))
    system = ObservedSystem("bag", (), topics)
    imported = to_model(system)
    assert errors(imported.model) == []
    assert imported.unseen == ("/unseen/publisher/x", "/unseen/publisher/y")
    assert imported.recorded == ("/x", "/y")
    assert differences(imported.model, system).findings == []
    said = read('[topic."/x"]\npublishers = ["/a"]\nsubscribers = ["/b"]\n')
    imported = to_model(system, said)
    assert [node.id for node in node_nets(imported.model)] == ["a", "b", "unseen_publisher_y"]


def test_services_of_a_recording_are_there_where_somebody_says_whose_they_are() -> None:
    services = (RecordedService("/ask", "std_srvs/srv/Trigger"),)
    system = ObservedSystem("bag", (), (RecordedTopic("/x", TEXT, (USUAL,)),), services=services)
    imported = to_model(system)
    assert imported.recorded == ("/x", "/ask")
    assert imported.left_out == ("service /ask: its events do not show which node serves it",)
    said = read('[service."/ask"]\nservers = ["/a"]\nclients = ["/b", "/c"]\n')
    imported = to_model(system, said)
    assert errors(imported.model) == []
    assert (imported.recorded, imported.left_out) == (("/x",), ())
    assert [node.id for node in node_nets(imported.model)] == ["a", "b", "c", "unseen_publisher_x"]
    assert differences(imported.model, system).findings == []
    other = to_model(system, read('[service."/other"]\nservers = []\n'))
    assert other.unused == ("/other",)


def test_a_managed_node_may_be_stopped_unless_it_is_said() -> None:
    system = ObservedSystem("nowhere", (ObservedNode("/a", publishers=(port("/x"),), lifecycle="active"),))
    (node,) = node_nets(to_model(system).model)
    assert node.lifecycle is not None
    assert node.lifecycle.deactivates
    (node,) = node_nets(to_model(system, read('[node."/a"]\nlifecycle = []\n')).model)
    assert node.lifecycle is not None
    assert not node.lifecycle.deactivates


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[node."/a"]\ncallback.timer.does = ["publish /z"]\n', "does not publish /z"),
        ('[node."/a"]\ncallback."/z".does = []\n', "the node has none"),
        ('[node."/a"]\ndepths."/z" = 3\n', "the node has none"),
        ('[node."/a"]\nnewest."/x" = true\n', "the node has none"),
    ],
)
def test_what_is_given_of_ports_that_are_not_there_is_refused(text: str, message: str) -> None:
    system = ObservedSystem("nowhere", (ObservedNode("/a", publishers=(port("/x"),)),))
    with pytest.raises(Exception, match=message):
        to_model(system, read(text))


def test_what_is_given_of_nodes_that_are_not_there_is_not_used() -> None:
    system = ObservedSystem("nowhere", (ObservedNode("/a"),))
    assert to_model(system, read('[node."/b"]\nthreads = 2\n')).unused == ("/b",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "\nx = " + "9" * 5000,
            ": is not TOML: a value cannot be read, for example a number",
        ),
        ("a." * 100_000 + "b = 1", ":1: a key of more than 64 parts with dots between them"),
        ("x = 1\n[" + "a . " * 100 + "b]\n", ":2: a key of more than 64 parts with dots between them"),
        ("x = {" + "'a'." * 100_000 + "b = 1}", ":1: a key of more than 64 parts with dots between them"),
        ("x = " + "[" * 50_000, ": is not TOML: nested too deep"),
        ("x = " + "{a = " * 50_000, ": is not TOML: nested too deep"),
        ("x = '" + "y" * (1 << 20) + "'", ": "),
    ],
)
def test_a_hostile_file_ends_in_one_line_at_once(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "robot.given.toml"
    path.write_text(text)
    begun = time.process_time()
    with pytest.raises(DinerosError) as raised:
        read_given(path)
    assert str(raised.value).startswith(f"{path}{message}")
    assert time.process_time() - begun < 2


def test_long_texts_with_dots_are_no_keys(tmp_path: Path) -> None:
    path = tmp_path / "robot.given.toml"
    sentences = "It waits, then it goes. " * 100
    path.write_text(f"# {sentences}\n[node.'/a']\nthreads = 2\n")
    assert read_given(path).node("/a").threads == 2
