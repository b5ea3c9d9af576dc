"""What services tell of their calls is read, put in order, and refused in one line where it is damaged."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from dineros.observation.recordings import Observed, Recording, RecordingError
from dineros.observation.systems import SERVICE_EVENTS, RecordedService
from tests.support.programs.bags import service_event, write_bag

SENT, RECEIVED, ANSWERED, TAKEN = range(4)
TOPIC = "/plan/_service_event"
MILLISECOND = 1_000_000


def observed(path: Path, told: Iterable[tuple[int, ...]]) -> tuple[Observed, list[str]]:
    """Return what is read of events (time in ms, kind, number, client); and the names of all messages."""
    messages = [(TOPIC, time * MILLISECOND, service_event(*event)) for time, *event in told]
    types = {TOPIC: "std_srvs/srv/Trigger_Event"}
    with Recording(write_bag(path / "bag", [*messages, ("/path", 99 * MILLISECOND)], types=types)) as bag:
        assert bag.services == (RecordedService("/plan", "std_srvs/srv/Trigger", len(messages)),)
        assert [topic.name for topic in bag.system().topics] == ["/path"]
        assert bag.system().services == bag.services
        found = Observed(bag)
        return found, [name for name, _ in found.messages()]


def names(*kinds: int) -> list[str]:
    return [*(f"/plan ({SERVICE_EVENTS[kind]})" for kind in kinds), "/path"]


def test_events_are_among_the_messages_by_their_names(tmp_path: Path) -> None:
    calls = [(1, SENT, 7), (2, RECEIVED, 7, 5), (5, ANSWERED, 7, 5), (9, TAKEN, 7), (20, SENT, 8)]
    found, told = observed(tmp_path, calls)
    assert told == names(SENT, RECEIVED, ANSWERED, TAKEN, SENT)
    assert {each.name: each.messages for each in found.recorded} == {
        "/path": 1,
        "/plan (request sent)": 2,
        "/plan (request received)": 1,
        "/plan (response sent)": 1,
        "/plan (response received)": 1,
    }
    assert found.calls["/plan"].answers == {
        "response sent": (1, 0.003, 0.003),
        "response received": (1, 0.008, 0.008),
    }


def test_what_is_told_late_is_put_before_what_follows_from_it(tmp_path: Path) -> None:
    calls = [(1, RECEIVED, 7), (2, SENT, 7), (30, TAKEN, 7), (31, ANSWERED, 7)]
    assert observed(tmp_path, calls)[1] == names(SENT, RECEIVED, ANSWERED, TAKEN)


def test_what_was_lost_or_comes_much_later_moves_nothing(tmp_path: Path) -> None:
    calls = [(1, RECEIVED, 7), (2, SENT, 8), (3, RECEIVED, 8), (2000, SENT, 7)]
    found, told = observed(tmp_path, calls)
    assert told == [names(RECEIVED)[0], *names(SENT, RECEIVED)[:2], "/path", names(SENT)[0]]
    assert found.calls["/plan"].answers == {}


def test_clients_that_tell_nothing_leave_the_events_of_the_others_out(tmp_path: Path) -> None:
    """The server hears two clients, and one tells: whether a request was sent is not always seen."""
    calls = [(1, SENT, 1, 3), (2, RECEIVED, 1, 4), (3, RECEIVED, 1, 5), (4, ANSWERED, 1, 4), (5, TAKEN, 1, 3)]
    found, told = observed(tmp_path, calls)
    assert told == names(RECEIVED, RECEIVED, ANSWERED)
    assert [each.name for each in found.recorded][1:] == [
        "/plan (request received)",
        "/plan (response sent)",
    ]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "has a message that is not an event"),
        (service_event(0, 1)[:20], "has a message that is not an event"),
        (b"\xff" * 44, "has a message that is not an event"),
        (service_event(4, 1), "has an event of the unknown kind 4"),
    ],
)
def test_what_is_no_event_is_one_line(data: bytes, message: str, tmp_path: Path) -> None:
    types = {TOPIC: "std_srvs/srv/Trigger_Event"}
    bag = write_bag(tmp_path / "bag", [(TOPIC, 1, data)], types=types)
    with Recording(bag) as recording, pytest.raises(RecordingError, match=message) as caught:
        Observed(recording)
    assert "\n" not in str(caught.value)


def test_what_ros_makes_by_itself_is_not_told_of_the_system(tmp_path: Path) -> None:
    types = {
        "/rosout": "rcl_interfaces/msg/Log",
        "/go/_action/status": "action_msgs/msg/GoalStatusArray",
        "/a/get_parameters/_service_event": "rcl_interfaces/srv/GetParameters_Event",
        "/b/_service_event": "std_msgs/msg/String",
    }
    messages = [(topic, 1) for topic in types if "parameters" not in topic]
    with Recording(write_bag(tmp_path / "bag", messages, types=types)) as bag:
        assert (bag.system().topics, bag.system().services) == ((), ())
        assert len(Observed(bag).recorded) == 3 and len(list(Observed(bag).messages())) == 3


@pytest.mark.parametrize(
    ("told", "untaken"),
    [
        ([(0, SENT, 1), (1, RECEIVED, 1, 5), (5, ANSWERED, 1, 5), (19_005, SENT, 2)], [(1, 19.0)]),
        ([(0, SENT, 1), (1, RECEIVED, 1, 5), (5, ANSWERED, 1, 5), (900, SENT, 2)], []),  # too soon to say
        ([(0, SENT, 1), (1, RECEIVED, 1, 5), (9_000, SENT, 2)], []),  # nobody answered
        ([(1, RECEIVED, 1, 5), (5, ANSWERED, 1, 5), (9_000, RECEIVED, 2, 5)], []),  # clients tell nothing
        ([(0, SENT, 1), (4, TAKEN, 1), (5, ANSWERED, 1, 5), (9_000, SENT, 2)], []),  # told in another order
        ([(0, SENT, 1), (0, SENT, 1, 2), (1, RECEIVED, 1, 5), (1, RECEIVED, 1, 6), (2, ANSWERED, 1, 5),
          (3, ANSWERED, 1, 6), (4, TAKEN, 1, 2), (5_003, SENT, 2)], [(1, 5.0)]),
        ([(0, SENT, 1), (1, ANSWERED, 1, 5), (2, TAKEN, 1), (3, SENT, 2), (4, ANSWERED, 2, 5), (5, SENT, 3),
          (6, ANSWERED, 3, 5), (7_004, SENT, 4)], [(2, 7.0)]),
    ],
)  # fmt: skip
def test_responses_that_no_client_took(
    told: list[tuple[int, ...]], untaken: list[tuple[int, float]], tmp_path: Path
) -> None:
    found, _ = observed(tmp_path, told)
    assert [(each.responses, each.seconds) for each in found.untaken] == untaken
    if untaken:
        assert str(found.untaken[0]).startswith(
            f"/plan: answered, never taken: {untaken[0][0]} response{'s' * (untaken[0][0] > 1)}, the "
            f"first one {untaken[0][1]:.3g} s before the end"
        )
