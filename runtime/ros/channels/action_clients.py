"""Action clients of rclpy that resend: goals with chosen ids, cancel requests, results, feedback.

`rclpy.action.ActionClient` sends a goal once and waits without limit; if the server dies, the goal is lost.
Here the client chooses the id of a goal, and the node is notified if no server answers, so that it can send
the goal again. A server refuses a repeated goal that it knows already. So after a refusal, the client asks
for the result, too: the goal is really refused only if the server does not know it. The result is requested
again when the status of the goal says that it has ended, and periodically.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from dineros.runtime.channels.goals import (
    CancelAnswered,
    ClientEvent,
    FeedbackArrived,
    GoalAnswered,
    GoalEnded,
    GoalFailed,
    GoalUnknown,
)
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import ActionClientPort, Message, OutcomeKind
from dineros.runtime.ros.channels.goal_ids import bytes_of, ros_id, text_of
from dineros.runtime.ros.channels.quality import SERVICE_DEPTH, reliable_quality
from dineros.runtime.ros.conversion.codecs import ActionCodecs
from dineros.runtime.ros.process.clocks import Alarm
from dineros.runtime.ros.process.session import LOG

FIRST_LOOK, LAST_LOOK = 0.05, 0.5
"""Seconds between checks for a missing server: the first delay, doubled up to the second."""

RESULT_DELAY = 0.3
"""Seconds after which the result of an ended goal is requested again."""

LONGEST_PERIOD = 60.0
"""Maximum time in seconds between two requests for a result."""

KEPT_GOALS = 16
"""Number of ended goals whose late feedback is still delivered."""


@dataclass(eq=False)
class _Goal:
    """A goal under way.

    Attributes
    ----------
    is_sent, is_accepted, is_refused : bool
        Progress of the goal; a refused goal waits for the result request, which shows whether the server
        knows it.
    deadline : float or None
        Time by which an answer must have arrived.
    look : float
        Seconds until the next check for the server, while the goal is not sent.
    ask, period : float
        Time of the next result request, and the delay after that one.
    cancel : float or None
        Time by which the cancel request is repeated; None: there is none, or it has been answered.
    """

    message: Message
    is_sent: bool = False
    is_accepted: bool = False
    is_refused: bool = False
    deadline: float | None = None
    look: float = FIRST_LOOK
    ask: float | None = None
    period: float = 0.0
    cancel: float | None = None


class GoalClient:
    """The client of an action; an answer may take `timeout` seconds."""

    def __init__(
        self, node: Any, port: ActionClientPort, codecs: ActionCodecs, receiver: Receiver, timeout: float
    ) -> None:
        from action_msgs.msg import GoalStatus

        self._port, self._codecs = port, codecs
        self._receiver, self._timeout = receiver, timeout
        self._ends: dict[int, OutcomeKind] = {
            GoalStatus.STATUS_SUCCEEDED: "succeeded",
            GoalStatus.STATUS_ABORTED: "aborted",
            GoalStatus.STATUS_CANCELED: "canceled",
        }
        self._unknown = GoalStatus.STATUS_UNKNOWN
        self._lock = threading.RLock()
        self._goals: dict[str, _Goal] = {}
        self._ended: dict[str, None] = {}
        self._client = _client_class()(node, codecs.interface, port, self)
        self._alarm: Alarm | None = Alarm(node, self._look)

    # Called by the net.

    def send(self, message: Message, *, is_accepted: bool = False) -> None:
        """Send a goal once the server is available, or follow a goal that was accepted before."""
        with self._lock:
            goal = self._goals.get(message.id)
            if goal is None:
                goal = self._goals[message.id] = _Goal(message)
            goal.is_accepted = goal.is_accepted or is_accepted
            goal.is_sent = goal.is_refused = False
            goal.deadline, goal.look = time.monotonic() + self._timeout, FIRST_LOOK
            self._go_on(goal)
            self._look_in_time(goal)

    def cancel(self, goal: str) -> None:
        """Ask to cancel a goal, repeatedly until the server answers."""
        with self._lock:
            known = self._goals.get(goal)
            if known is not None:
                self._ask_to_cancel(known)
                self._look_in_time(known)

    def _go_on(self, goal: _Goal) -> None:
        """Send a goal, or ask for its result, if the server is available."""
        if not self._client.server_is_ready():
            return
        goal.is_sent = True
        if goal.is_accepted:
            goal.deadline = None
            self._ask_for_result(goal)
        else:
            self._client.send_goal(goal.message.id, self._codecs.goal.encode(goal.message))

    def _ask_for_result(self, goal: _Goal) -> None:
        self._client.ask_for_result(goal.message.id)
        goal.period = min(LONGEST_PERIOD, 2 * goal.period or self._timeout)
        goal.ask = time.monotonic() + goal.period

    def _ask_to_cancel(self, goal: _Goal) -> None:
        goal.cancel = time.monotonic() + (self._timeout if self._client.server_is_ready() else LAST_LOOK)
        if self._client.server_is_ready():
            self._client.ask_to_cancel(goal.message.id)

    # Timers.

    def _look_in_time(self, goal: _Goal) -> None:
        """Set the alarm to the next time at which a goal needs an action, unless it is earlier already."""
        now = time.monotonic()
        times = [goal.deadline, goal.ask, goal.cancel, None if goal.is_sent else now + goal.look]
        if self._alarm is not None:
            self._alarm.set(min((each for each in times if each is not None), default=None))

    def _look(self) -> None:
        """Perform all actions that are due."""
        with self._lock:
            if self._alarm is None:
                return
            self._alarm.silence()
            now = time.monotonic()
            for goal in list(self._goals.values()):
                try:
                    self._look_at(goal, now)
                except Exception as error:
                    LOG.error("goal %s of %s: %s", goal.message.id, self._port.action, error)
                self._look_in_time(goal)

    def _look_at(self, goal: _Goal, now: float) -> None:
        if not goal.is_sent:
            goal.look = min(LAST_LOOK, 2 * goal.look)
            self._go_on(goal)
        if goal.deadline is not None and now >= goal.deadline:
            reason = "no answer" if goal.is_sent else "no server is available"
            goal.deadline = None
            if goal.is_accepted:
                goal.deadline = now + self._timeout  # only checks for the server remain to be done
            else:
                self._tell(GoalFailed(goal.message.id, f"{reason} in {self._timeout:g} s"))
        if goal.is_sent and goal.ask is not None and now >= goal.ask:
            self._ask_for_result(goal)
        if goal.cancel is not None and now >= goal.cancel:
            self._ask_to_cancel(goal)

    # Called when the server answers, on a thread of the executor.

    def answered(self, id: str, accepted: bool) -> None:
        """Handle the server's answer to a goal."""
        with self._lock:
            goal = self._goals.get(id)
            if goal is None or goal.is_accepted:
                return
            if accepted:
                self._accept(goal)
            else:
                goal.is_refused = True
            self._ask_for_result(goal)
            self._look_in_time(goal)

    def _accept(self, goal: _Goal) -> None:
        goal.is_accepted, goal.deadline, goal.is_refused = True, None, False
        self._tell(GoalAnswered(goal.message.id, True))

    def status(self, id: str, status: int) -> None:
        """Handle the status that the server reports for a goal."""
        with self._lock:
            goal = self._goals.get(id)
            if goal is None or status == self._unknown:
                return
            if goal.is_refused:  # a repeated goal
                self._accept(goal)
            if status in self._ends and goal.is_accepted:
                soon = time.monotonic() + RESULT_DELAY
                goal.ask = min(goal.ask or soon, soon)
            self._look_in_time(goal)

    def result(self, id: str, status: int, result: Any) -> None:
        """Handle the result of a goal, or the response that the server does not know it."""
        with self._lock:
            goal = self._goals.get(id)
            if goal is None:
                return
            outcome = self._ends.get(status)
            if outcome is None and goal.is_refused:
                self._forget(goal)
                self._tell(GoalAnswered(id, False))
            elif outcome is None and goal.is_accepted:
                self._forget(goal)
                self._tell(GoalUnknown(id))
            elif outcome is not None:
                try:
                    data = self._codecs.decode_result(result)
                except Exception as error:  # ROS may raise any exception
                    LOG.error("the result of %s cannot be read: %s", self._port.action, error)
                    data = {}
                self._forget(goal)
                self._tell(GoalEnded(id, outcome, data))

    def _forget(self, goal: _Goal) -> None:
        del self._goals[goal.message.id]
        self._ended[goal.message.id] = None
        if len(self._ended) > KEPT_GOALS:
            del self._ended[next(iter(self._ended))]

    def canceled(self, id: str, accepted: bool) -> None:
        """Handle the answer to a cancel request."""
        with self._lock:
            goal = self._goals.get(id)
            if goal is not None and goal.cancel is not None:
                goal.cancel = None
                self._tell(CancelAnswered(id, accepted))

    def heard(self, id: str, feedback: Any) -> None:
        """Handle feedback on a goal of this or of another client."""
        if id in self._goals or id in self._ended:
            try:
                number, data = self._codecs.decode_feedback(feedback)
            except Exception as error:
                LOG.error("feedback of %s cannot be read: %s", self._port.action, error)
                return
            self._tell(FeedbackArrived(id, number, data))

    def _tell(self, event: ClientEvent) -> None:
        self._receiver.action_event(self._port, event)

    def close(self) -> None:
        """Destroy the client; no further events are reported."""
        with self._lock:
            self._goals.clear()
            self._ended.clear()
            alarm, self._alarm = self._alarm, None
        if alarm is not None:
            alarm.close()
        self._client.destroy()


def _client_class() -> Any:
    """Return the class of clients; rclpy is imported only if there is one."""
    from action_msgs.srv import CancelGoal
    from rclpy.action.client import ActionClient
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

    action_client: Any = ActionClient  # without type hints

    class Client(action_client):  # type: ignore[misc]
        def __init__(self, node: Any, interface: Any, port: ActionClientPort, owner: GoalClient) -> None:
            quality = reliable_quality(SERVICE_DEPTH)
            self._owner = owner
            self._asked: dict[str, dict[int, str]] = {"goal": {}, "result": {}, "cancel": {}}
            self._parts = interface.Impl
            super().__init__(
                node,
                interface,
                port.action,
                callback_group=MutuallyExclusiveCallbackGroup(),
                goal_service_qos_profile=quality,
                result_service_qos_profile=quality,
                cancel_service_qos_profile=quality,
                feedback_sub_qos_profile=reliable_quality(max(1, port.depth)),
            )

        def send_goal(self, id: str, goal: Any) -> None:
            request = self._parts.SendGoalService.Request(goal_id=ros_id(bytes_of(id)), goal=goal)
            self._note("goal", self._client_handle.send_goal_request(request), id)

        def ask_for_result(self, id: str) -> None:
            request = self._parts.GetResultService.Request(goal_id=ros_id(bytes_of(id)))
            self._note("result", self._client_handle.send_result_request(request), id)

        def ask_to_cancel(self, id: str) -> None:
            request = CancelGoal.Request()
            request.goal_info.goal_id = ros_id(bytes_of(id))
            self._note("cancel", self._client_handle.send_cancel_request(request), id)

        def _note(self, kind: str, number: int, id: str) -> None:
            asked = self._asked[kind]
            asked[number] = id
            while len(asked) > 1000:  # requests without a response
                del asked[next(iter(asked))]

        def _answered(self, kind: str, taken_data: Any) -> Iterator[tuple[str, Any]]:
            """Yield the goal to which a response belongs, and the response; nothing for unknown requests."""
            if kind in taken_data:
                number, response = taken_data[kind]
                id = self._asked[kind].pop(int(getattr(number, "sequence_number", number)), None)
                if id is not None:
                    yield id, response

        async def execute(self, taken_data: Any) -> None:
            """Deliver arrivals, feedback first: a result may have arrived with it."""
            owner = self._owner
            if "feedback" in taken_data:
                message = taken_data["feedback"]
                owner.heard(text_of(message.goal_id), message.feedback)
            for id, response in self._answered("goal", taken_data):
                owner.answered(id, bool(response.accepted))
            for id, response in self._answered("cancel", taken_data):
                owner.canceled(id, id in [text_of(info.goal_id) for info in response.goals_canceling])
            if "status" in taken_data:
                for each in taken_data["status"].status_list:
                    owner.status(text_of(each.goal_info.goal_id), int(each.status))
            for id, response in self._answered("result", taken_data):
                owner.result(id, int(response.status), response.result)

    return Client
