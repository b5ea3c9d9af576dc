"""Goals of actions between nodes: accepted, refused, canceled in time and too late, kept over restarts."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.metamodel.records import Checkpoint as CheckpointRecord
from dineros.metamodel.records import decode_record, encode_fields
from dineros.runtime import Net, Node
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.channels import goals
from dineros.runtime.channels.transport import Receiver, Transport
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.firing.handlers import HandlerError
from dineros.runtime.journal.rebuilding import rebuild
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionServerPort,
    ClientPort,
    Data,
    Message,
    OutcomeKind,
    Ports,
    PublisherPort,
)
from dineros.transformations.flattening.split import split
from tests.runtime.tiny import events
from tests.support.ros2_systems.deliveries import deliveries, regretting_any_time


def parts(**options: Any) -> dict[str, rtm.RuntimeModel]:
    return {part.node.id: part for part in split(deliveries(**options))}


class Wire(Transport):
    """A transport of actions whose other end is the test."""

    def __init__(self) -> None:
        self.sent: list[tuple[Any, ...]] = []
        self.known: list[goals.KnownGoal] = []
        self.fails = False

    def open(self, ports: Ports, receiver: Receiver) -> None:
        self.ports, self.receiver = ports, receiver

    def publish(self, port: PublisherPort, message: Message) -> bool:
        raise NotImplementedError

    def request(self, port: ClientPort, message: Message) -> None:
        raise NotImplementedError

    def restore_goals(self, port: ActionServerPort, goals: Sequence[goals.KnownGoal]) -> None:
        self.known = list(goals)

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        self._send("goal", message.id)

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        self._send("follow", message.id)

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        self._send("cancel", goal)

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        self._send("feedback", goal, number)

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        self._send("finish", goal, outcome)

    def _send(self, *what: Any) -> None:
        if self.fails:
            raise OSError("the cable is out")
        self.sent.append(what)

    def close(self) -> None:
        pass


class Bench:
    """A node on a wire; nothing but `only` fires."""

    def __init__(self, model: rtm.RuntimeModel, resume: SavedState | None = None) -> None:
        self.now = 0.0
        self.net, self.wire, self.recorder = Net(model, clock=lambda: self.now), Wire(), ListRecorder()
        self.node = Node(self.net, self.wire, self.recorder, resume=resume)
        self.only: set[str] = set()
        self.net.selection(
            lambda enabled: next((each for each in enabled if each.transition in self.only), None)
        )
        self.node.open()
        self.node.run_until_idle()
        self.answers: list[tuple[str, Any]] = []

    def tell(self, event: goals.ActionEvent) -> None:
        ports = self.wire.ports
        port = (*ports.action_servers, *ports.action_clients)[0]
        self.wire.receiver.action_event(port, event)
        self.node.run_until_idle()

    def ask(self, goal: str) -> None:
        message = Message(goal, {})
        self.tell(goals.GoalArrived(message, lambda accepted: self.answers.append((goal, accepted))))

    def cancel(self, *asked: str) -> None:
        self.tell(goals.CancelArrived(asked, lambda found: self.answers.append(("cancel", list(found)))))

    def fire(self, *transitions: str) -> None:
        for transition in transitions:
            self.only = {transition}
            self.node.run_until_idle()
        self.only = set()

    def pass_time(self, seconds: float) -> None:
        self.now += seconds
        self.node.run_until_idle()

    @property
    def marked(self) -> dict[str, int]:
        return {place: len(tokens) for place, tokens in self.net.inspect().marking.items() if tokens}

    def recorded(self, *wanted: str) -> list[str]:
        known = (str(record["event"]) for record in self.recorder.records)
        return [event for event in known if not wanted or event in wanted]


def server(resume: SavedState | None = None, **options: Any) -> Bench:
    return Bench(parts(feedback=True, **{"slots": 1, **options})["robot"], resume)


def client(resume: SavedState | None = None, **options: Any) -> Bench:
    return Bench(parts(feedback=True, **options)["office0"], resume)


# The server.


def test_a_goal_is_worked_on_gives_feedback_and_succeeds() -> None:
    bench = server()
    bench.ask("g")
    assert bench.answers == [("g", True)]
    assert bench.marked == {"Delivery[1].Parcel": 1}
    bench.fire("Start", "Arrive")
    assert bench.wire.sent == [("feedback", "g", 1), ("finish", "g", "succeeded")]
    assert bench.marked == {}
    bench.ask("h")
    bench.fire("Start", "Break")
    assert bench.wire.sent[-1] == ("finish", "h", "aborted")


def test_a_server_that_may_not_refuse_lets_goals_wait_for_a_slot() -> None:
    bench = server(rejects=False)
    for goal in "ghi":
        bench.ask(goal)
    assert bench.answers == [("g", True)]
    bench.fire("Start", "Arrive")
    assert bench.answers == [("g", True), ("h", True)]
    assert bench.net.core.exchange is not None
    assert bench.net.core.exchange.actions.waiting_goals == 1


def test_a_server_that_may_refuse_does_so_when_no_slot_is_free() -> None:
    bench = server(slots=2)
    for goal in "ghi":
        bench.ask(goal)
    assert bench.answers == [("g", True), ("h", True), ("i", False)]
    assert len(events(bench.recorder, "accept")) == 2


def test_a_goal_that_comes_twice_is_worked_on_once() -> None:
    bench = server()
    bench.ask("g")
    bench.ask("g")
    bench.fire("Start", "Arrive")
    bench.ask("g")
    assert bench.answers == [("g", True)] * 3
    assert bench.recorded("accept", "finish") == ["accept", "finish"]


def test_a_goal_is_canceled_while_it_is_worked_on() -> None:
    bench = server()
    bench.ask("g")
    bench.fire("Start")
    bench.cancel("g")
    assert bench.answers[-1] == ("cancel", ["g"])
    assert bench.marked == {"Delivery[1].Driving": 1, "Delivery[1].Stop": 1}
    bench.cancel("g")  # once more
    assert bench.answers[-1] == ("cancel", ["g"])
    assert bench.marked["Delivery[1].Stop"] == 1
    bench.fire("Return")
    assert bench.wire.sent[-1] == ("finish", "g", "canceled")
    assert bench.marked == {}
    bench.cancel("g", "unknown")  # too late
    assert bench.answers[-1] == ("cancel", [])


def test_a_request_that_is_not_heeded_is_not_left_to_the_next_goal() -> None:
    bench = server()
    bench.ask("g")
    bench.fire("Start")
    bench.cancel("g")
    bench.fire("Arrive")
    assert bench.wire.sent[-1] == ("finish", "g", "succeeded")
    (finish,) = events(bench.recorder, "finish")
    assert finish["change"] == {"Delivery[1].At": -1, "Delivery[1].Stop": -1}
    bench.ask("h")
    assert bench.marked == {"Delivery[1].Parcel": 1}


def test_a_server_without_a_place_for_it_refuses_all_requests_to_cancel() -> None:
    bench = server(cancels=0)
    bench.ask("g")
    bench.cancel("g")
    assert bench.answers[-1] == ("cancel", [])


def test_a_result_that_cannot_be_sent_stays() -> None:
    bench = server()
    bench.ask("g")
    bench.fire("Start")
    bench.wire.fails = True
    bench.fire("Arrive")
    assert bench.marked == {"Delivery[1].At": 1}
    assert "cannot send a result" in str(events(bench.recorder, "error")[0]["error"])
    bench.wire.fails = False
    bench.pass_time(1.1)
    assert bench.marked == {}
    assert bench.wire.sent[-1] == ("finish", "g", "succeeded")


def test_a_server_goes_on_with_its_goals_and_knows_those_that_ended() -> None:
    bench = server(slots=2)
    bench.ask("g")
    bench.fire("Start", "Arrive")
    bench.ask("h")
    bench.ask("i")
    bench.fire("Start")
    bench.cancel("h")
    other = server(slots=2, resume=bench.node.checkpoint())
    assert [(each.message.id, each.outcome, each.is_canceling) for each in other.wire.known] == [
        ("g", "succeeded", False),
        ("h", None, True),
        ("i", None, False),
    ]
    assert sorted(other.wire.sent) == [("feedback", "h", 1), ("feedback", "i", 1)]
    other.ask("g")
    other.ask("h")
    assert other.answers == [("g", True), ("h", True)]
    other.fire("Return")
    assert other.wire.sent[-1] == ("finish", "h", "canceled")
    assert "Delivery[2].Driving" in other.marked


def test_handlers_learn_of_the_request_to_cancel() -> None:
    bench = server()
    seen: list[bool] = []

    @bench.net.handler("Start")
    def start(firing: Any) -> None:
        seen.append(firing.cancel.is_requested)

    @bench.net.handler("Return")
    def back(firing: Any) -> None:
        seen.append(firing.cancel.wait(0))

    bench.ask("g")
    bench.fire("Start")
    bench.cancel("g")
    bench.fire("Return")
    bench.ask("h")
    bench.fire("Start")
    assert seen == [False, True, False]


def test_a_coroutine_awaits_the_request_to_cancel() -> None:
    request = CancelRequest()

    async def wait() -> bool:
        asyncio.get_running_loop().call_later(0.01, request.set)
        await request
        return request.is_requested

    # In a thread of its own: Playwright leaves a loop running in the main thread of a process.
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(asyncio.run, wait()).result(10)


# The client.


def goal_of(bench: Bench) -> str:
    return str(bench.wire.sent[0][1])


def test_a_client_sends_the_next_goal_when_the_last_one_has_ended() -> None:
    bench = client(goals=2, cancels=0)
    assert [what for what, *_ in bench.wire.sent] == ["goal"]
    first = goal_of(bench)
    bench.tell(goals.GoalAnswered(first, True))
    bench.tell(goals.FeedbackArrived(first, 1, {}))
    bench.tell(goals.GoalEnded(first, "succeeded", {}))
    assert bench.marked == {"Delivered0": 1, "Heard0": 1}
    second = str(bench.wire.sent[1][1])
    assert second not in (first, "")
    bench.tell(goals.FeedbackArrived(first, 1, {}))  # sent again
    bench.tell(goals.FeedbackArrived(first, 3, {}))  # late, and one is missing
    bench.tell(goals.GoalAnswered(second, False))
    assert bench.marked == {"Delivered0": 1, "Heard0": 2, "Refused0": 1}
    assert [record["count"] for record in events(bench.recorder, "drop")] == [1]


def test_a_client_that_is_not_answered_sends_the_same_goal_again() -> None:
    bench = client(cancels=0)
    goal = goal_of(bench)
    for _ in range(2):
        bench.tell(goals.GoalFailed(goal, "nobody is there"))
        bench.pass_time(10)
    assert [each for each in bench.wire.sent if each[0] == "goal"] == [("goal", goal)] * 3
    assert [record["attempt"] for record in events(bench.recorder, "timeout")] == [1, 2]


def test_a_request_to_cancel_waits_until_the_goal_is_accepted() -> None:
    bench = client(goals=1, cancels=1)
    bench.fire("Order0", "Regret0")
    goal = goal_of(bench)
    assert bench.marked == {"Recall0": 1}
    bench.tell(goals.GoalAnswered(goal, True))
    assert bench.wire.sent[-1] == ("cancel", goal)
    assert bench.marked == {}
    bench.tell(goals.CancelAnswered(goal, False))
    assert bench.recorded("cancel", "tooLate") == ["cancel", "tooLate"]


def test_no_more_requests_to_cancel_wait_than_goals_are_under_way() -> None:
    """A third one of two goals is gone at once; those of a refused goal are gone before it is over."""
    model = deliveries(goals=3, cancels=4)
    (channel,) = model.channels
    assert isinstance(channel, sym.ActionChannel)
    channel.clients[0].outstanding = 2
    regretting_any_time(model)
    bench = Bench(next(part for part in split(model) if part.node.id == "office0"))
    bench.fire("Order0")
    first, second = (what[1] for what in bench.wire.sent if what[0] == "goal")
    bench.fire("Regret0")
    assert bench.recorded("cancel") == ["cancel", "cancel"] and bench.marked["Recall0"] == 2
    bench.tell(goals.GoalAnswered(first, False))
    assert bench.marked["Recall0"] == 1
    assert [what for what, *_ in bench.wire.sent] == ["goal", "goal", "goal"]
    bench.tell(goals.GoalAnswered(second, True))
    assert bench.wire.sent[-1] == ("cancel", second)
    assert "Recall0" not in bench.marked


def test_a_request_to_cancel_that_comes_with_its_goal_is_gone_before_the_goal_is_sent() -> None:
    """Both come from one firing: the client has no goal under way that it could mean."""
    model = deliveries(feedback=True)
    office = find(model, "office0", sym.NodeNet)
    both = sym.Transition(id="Both", page=office)
    flow(find(model, "Wanted0", pn.Place), both, find(model, "Send0", pn.Place))
    flow(both, find(model, "Recall0", pn.Place))
    bench = Bench(next(part for part in split(model) if part.node.id == "office0"))
    bench.fire("Both")
    assert bench.recorded("cancel", "goal") == ["cancel", "goal"]
    bench.tell(goals.GoalAnswered(goal_of(bench), True))
    assert [what for what, *_ in bench.wire.sent] == ["goal"]
    assert bench.marked == {"Doubt0": 1}


def test_a_lost_goal_counts_as_aborted_once_it_was_accepted() -> None:
    bench = client(cancels=0)
    goal = goal_of(bench)
    bench.tell(goals.GoalUnknown(goal))
    assert bench.recorded("timeout") == ["timeout"]
    bench.tell(goals.GoalAnswered(goal, True))
    bench.tell(goals.GoalUnknown(goal))
    assert bench.marked == {"Failed0": 1}
    assert "has lost the goal" in str(events(bench.recorder, "error")[0]["error"])


def test_a_client_goes_on_with_the_goal_it_had() -> None:
    bench = client(cancels=0, goals=2)
    goal = goal_of(bench)
    again = client(cancels=0, goals=2, resume=bench.node.checkpoint())
    assert again.wire.sent == [("goal", goal)]
    again.tell(goals.GoalAnswered(goal, True))
    again.tell(goals.FeedbackArrived(goal, 1, {}))
    followed = client(cancels=0, goals=2, resume=again.node.checkpoint())
    assert followed.wire.sent == [("follow", goal)]
    followed.tell(goals.FeedbackArrived(goal, 1, {}))  # it had that
    followed.tell(goals.GoalEnded(goal, "aborted", {}))
    assert followed.marked == {"Failed0": 1, "Heard0": 1}
    assert followed.wire.sent[-1] == ("goal", followed.wire.sent[-1][1]) != ("goal", goal)


# Both, in one process.


def application(seed: int, recorders: dict[str, ListRecorder], **options: Any) -> LocalApplication:
    def recorder(node: str) -> ListRecorder:
        return recorders.setdefault(node, ListRecorder())

    return LocalApplication(parts(**options).values(), seed=seed, recorder=recorder)


def test_each_goal_ends_once_and_journals_tell_the_state() -> None:
    """Goals of three clients for two slots, some canceled: all ends are reached, nothing is left."""
    ends: Counter[str] = Counter()
    for seed in range(12):
        recorders: dict[str, ListRecorder] = {}
        options = {"clients": 3, "slots": 2, "goals": 3, "cancels": 2, "feedback": True}
        with application(seed, recorders, rejects=seed % 2 == 0, **options) as running:
            for steps in (15, 40, 2000):
                for _ in range(steps):
                    running.step()
                for id, node in running.nodes.items():
                    _compare(recorders[id], node.checkpoint())
            marking = {id: net.inspect().marking for id, net in running.nets.items()}
        assert not any(marking["robot"].values())
        for number in range(3):
            own = {place: len(tokens) for place, tokens in marking[f"office{number}"].items() if tokens}
            over = sum(own.get(f"{end}{number}", 0) for end in ("Delivered", "Failed", "Refused", "Canceled"))
            assert over == 3
            ends.update({place[:-1]: count for place, count in own.items()})
        accepted = {str(r["message"]) for r in events(recorders["robot"], "accept")}
        finished = [str(r["message"]) for r in events(recorders["robot"], "finish")]
        assert sorted(finished) == sorted(accepted)
    assert {"Delivered", "Failed", "Refused", "Canceled"} <= set(ends)


def _compare(recorder: ListRecorder, checkpoint: SavedState) -> None:
    """Compare what a journal tells with what the node knows."""
    skipped = ("sequence", "event")
    lines = [
        encode_fields(
            str(record["event"]),
            int(str(record["sequence"])),
            {name: value for name, value in record.items() if name not in skipped},
        )
        for record in recorder.records
    ]
    told: Any = rebuild(map(decode_record, lines)).checkpoint()
    for field in ("marking", "goals", "slots", "results", "numbers"):
        assert told[field] == _plain(checkpoint[field]), field


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value


@pytest.mark.parametrize("dies", ["robot", "office0"])
def test_a_node_that_is_started_again_loses_and_repeats_no_goal(dies: str) -> None:
    for seed in range(8):
        recorders: dict[str, ListRecorder] = {}
        options = {"clients": 2, "goals": 2, "cancels": 1, "feedback": True, "rejects": False}
        with application(seed, recorders, **options) as running:
            for _ in range(10 + 3 * seed):
                running.step()
            before = running.nodes[dies]
            checkpoint = before.checkpoint()
            before.close()
            reborn = Node(Net(parts(**options)[dies], seed=seed), running.network.transport(),
                          recorders[dies], resume=checkpoint)  # fmt: skip
            running.nodes[dies], running.nets[dies] = reborn, reborn.net
            reborn.open()
            for _ in range(1500):
                running.step()
            marking = {id: net.inspect().marking for id, net in running.nets.items()}
        assert not any(marking["robot"].values())
        accepted = [str(r["message"]) for r in events(recorders["robot"], "accept")]
        finished = [str(r["message"]) for r in events(recorders["robot"], "finish")]
        assert len(accepted) == len(set(accepted)) == 4
        assert sorted(finished) == sorted(accepted)
        for number in range(2):
            got = events(recorders[f"office{number}"], "outcome")
            assert len(got) == len({r["message"] for r in got}) == 2


def test_a_checkpoint_with_goals_is_a_record() -> None:
    bench = server()
    bench.ask("g")
    record = decode_record(encode_fields("checkpoint", 0, bench.node.checkpoint()))
    assert isinstance(record, CheckpointRecord)
    assert record.slots["Delivery[1].Parcel"]["message"] == "g"


def test_developers_decide_which_goals_are_accepted() -> None:
    """One that their function fails for is refused, and the error recorded; nothing of it is worked on."""
    bench = server(slots=3)
    seen: list[Data] = []

    @bench.net.accepts("Delivery")
    def is_light(goal: Data) -> bool:
        seen.append(goal)
        if len(seen) == 3:
            raise RuntimeError("the scales are broken")
        return len(seen) != 2

    for goal in "ghig":
        bench.ask(goal)
    assert bench.answers == [("g", True), ("h", False), ("i", False), ("g", True)]
    assert len(seen) == 3, "what is worked on is not asked about again"
    assert bench.marked == {"Delivery[1].Parcel": 1}
    (error,) = events(bench.recorder, "error")
    assert "is_light" in str(error["error"]) and "the scales are broken" in str(error["error"])


def test_only_what_the_model_lets_refuse_goals_has_a_say() -> None:
    with pytest.raises(HandlerError, match="the server of action Delivery must not reject goals"):
        server(rejects=False).net.accepts("Delivery")(bool)
    with pytest.raises(HandlerError, match="the node serves no action 'Delivry'"):
        server().net.accepts("Delivry")(bool)
