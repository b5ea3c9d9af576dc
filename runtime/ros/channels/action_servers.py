"""An action server of rclpy that answers when the net answers, and continues after a restart.

`rclpy.action.ActionServer` must know at once whether it accepts a goal, and runs a function for each goal.
Here, a goal waits for its answer until a slot of the net is free, and the slot executes it; the callbacks of
rclpy only deliver requests. The state machine of goals, the status topic and the lifetime of results are
those of rcl.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

from dineros.runtime.channels.goals import CancelArrived, GoalArrived, KnownGoal
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import ActionServerPort, Data, Message, OutcomeKind
from dineros.runtime.ros.channels.goal_ids import bytes_of, ros_id, text_of
from dineros.runtime.ros.channels.quality import SERVICE_DEPTH, reliable_quality
from dineros.runtime.ros.conversion.codecs import ActionCodecs
from dineros.runtime.ros.process.session import LOG

KEPT_ASKS = 64
"""Maximum number of waiting requests for the result of one goal; the last ones are kept."""


class GoalServer:
    """The server of an action; the receiver gets goals and cancel requests."""

    def __init__(self, node: Any, port: ActionServerPort, codecs: ActionCodecs, receiver: Receiver) -> None:
        from action_msgs.msg import GoalStatus
        from rclpy.action.server import GoalEvent

        self._port, self._codecs, self._receiver = port, codecs, receiver
        self._parts = codecs.interface.Impl
        self._events = GoalEvent
        self._ends = {
            "succeeded": (GoalEvent.SUCCEED, GoalStatus.STATUS_SUCCEEDED),
            "aborted": (GoalEvent.ABORT, GoalStatus.STATUS_ABORTED),
            "canceled": (GoalEvent.CANCELED, GoalStatus.STATUS_CANCELED),
        }
        self._is_canceling = GoalStatus.STATUS_CANCELING
        self._node = node
        self._lock = threading.Lock()
        self._waiting: dict[bytes, list[Any]] = {}  # headers of clients that wait for a result
        self._results: dict[bytes, Any] = {}
        self._is_open = True
        self._server = _server_class()(node, codecs.interface, port, self)

    # Called by rclpy.

    def asked(self, header: Any, request: Any) -> None:
        """Deliver a goal."""
        goal = text_of(request.goal_id)
        answer = partial(self._answer, header, request.goal_id)
        try:
            data = self._codecs.goal.decode(request.goal).data
        except Exception as error:  # ROS may raise any exception
            self._receiver.refused(self._port, error)
            answer(False)
            return
        if self._is_open:
            self._receiver.action_event(self._port, GoalArrived(Message(goal, data), answer))

    def asked_to_cancel(self, header: Any, request: Any) -> None:
        """Deliver a cancel request: for one goal, for all, or for those accepted before some time."""
        response = self._server.cancelable(request)
        named = text_of(request.goal_info.goal_id)
        goals = [text_of(info.goal_id) for info in response.goals_canceling]
        if not goals and self._server.status_of(bytes_of(named)) == self._is_canceling:
            response.goals_canceling, goals = [request.goal_info], [named]
        if not goals:
            self._server.respond("cancel", header, response)
        elif self._is_open:
            answer = partial(self._answer_cancel, header, response)
            self._receiver.action_event(self._port, CancelArrived(goals, answer))

    def asked_for_result(self, header: Any, request: Any) -> None:
        """Respond with a result, as soon as there is one."""
        goal = bytes(request.goal_id.uuid)
        with self._lock:
            result = self._results.get(goal)
            if result is None and self._server.knows(goal):
                waiting = self._waiting.setdefault(goal, [])
                waiting.append(header)
                del waiting[:-KEPT_ASKS]
                return
        if result is None:
            result = self._parts.GetResultService.Response()  # the default status is that of unknown goals
        self._server.respond("result", header, result)

    def expired(self, goals: Sequence[bytes]) -> None:
        """Remove results whose time has expired."""
        with self._lock:
            for goal in goals:
                self._results.pop(goal, None)
                self._waiting.pop(goal, None)

    # Called by the net.

    def _answer(self, header: Any, goal_id: Any, accepted: bool) -> None:
        """Send the answer to a goal to its client; from the thread of the net."""
        if not self._is_open:
            return
        response = self._parts.SendGoalService.Response()
        try:
            handle = self._server.accepted(goal_id) if accepted else None
            response.accepted = handle is not None
            if handle is not None:
                response.stamp = handle.stamp
            self._server.respond("goal", header, response)
            if handle is not None:
                self._server.begin(bytes(goal_id.uuid))
        except Exception as error:
            LOG.error("a goal of %s is not answered: %s", self._port.action, error)

    def _answer_cancel(self, header: Any, response: Any, goals: Sequence[str]) -> None:
        if not self._is_open:
            return
        try:
            for goal in goals:
                self._server.cancel(bytes_of(goal))
            response.goals_canceling = [
                info for info in response.goals_canceling if text_of(info.goal_id) in goals
            ]
            if not response.goals_canceling:
                response.return_code = response.ERROR_REJECTED
            self._server.respond("cancel", header, response)
        except Exception as error:
            LOG.error("a request to cancel goals of %s is not answered: %s", self._port.action, error)

    def restore(self, goals: Sequence[KnownGoal]) -> None:
        """Restore the goals from before a restart."""
        for goal in goals:
            id = bytes_of(goal.message.id)
            self._server.accepted(ros_id(id))
            self._server.begin(id)
            if goal.is_canceling or goal.outcome == "canceled":
                self._server.cancel(id)
            if goal.outcome is not None:
                self.finish(goal.message.id, goal.outcome, goal.message.data)

    def feedback(self, goal: str, number: int, data: Data) -> None:
        """Publish feedback."""
        self._server.publish_feedback(bytes_of(goal), self._codecs.encode_feedback(goal, number, data))

    def finish(self, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """End a goal, and respond to the clients that wait for its result."""
        id = bytes_of(goal)
        event, status = self._ends[outcome]
        response = self._parts.GetResultService.Response()
        response.result = self._codecs.encode_result(goal, data)
        response.status = status
        self._server.end(id, event)
        with self._lock:
            self._results[id] = response
            waiting = self._waiting.pop(id, [])
        for header in waiting:
            self._server.respond("result", header, response)

    def close(self) -> None:
        """Destroy the server."""
        self._is_open = False
        self._server.destroy()


class _Handle(NamedTuple):
    """A goal registered in rcl, with the time when it was accepted."""

    goal: Any
    stamp: Any


def _server_class() -> Any:
    """Return the class of servers; rclpy is imported only if there is one."""
    from action_msgs.msg import GoalInfo, GoalStatus
    from rclpy.action.server import ActionServer, GoalEvent, RCLError, ServerGoalHandle
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

    action_server: Any = ActionServer  # without type hints

    class Server(action_server):  # type: ignore[misc]
        def __init__(self, node: Any, interface: Any, port: ActionServerPort, owner: GoalServer) -> None:
            self._owner = owner
            self._known: dict[bytes, _Handle] = {}
            quality = reliable_quality(SERVICE_DEPTH)
            super().__init__(
                node,
                interface,
                port.action,
                lambda handle: None,
                callback_group=MutuallyExclusiveCallbackGroup(),
                goal_service_qos_profile=quality,
                result_service_qos_profile=quality,
                cancel_service_qos_profile=quality,
                feedback_pub_qos_profile=reliable_quality(max(1, port.depth)),
            )

        async def _execute_goal_request(self, taken: Any) -> None:
            self._owner.asked(*taken)

        async def _execute_cancel_request(self, taken: Any) -> None:
            self._owner.asked_to_cancel(*taken)

        async def _execute_get_result_request(self, taken: Any) -> None:
            self._owner.asked_for_result(*taken)

        async def _execute_expire_goals(self, expired: Any) -> None:
            goals = [bytes(info.goal_id.uuid) for info in expired]
            self._owner.expired(goals)
            for goal in goals:
                self._goal_handles.pop(goal, None)
                handle = self._known.pop(goal, None)
                if handle is not None:
                    handle.goal.destroy()

        def knows(self, goal: bytes) -> bool:
            return goal in self._known

        def status_of(self, goal: bytes) -> int:
            handle = self._known.get(goal)
            return 0 if handle is None else int(handle.goal.status)

        def cancelable(self, request: Any) -> Any:
            with self._lock:
                kind = self._action_type.Impl.CancelGoalService.Response
                return self._handle.process_cancel_request(request, kind)

        def accepted(self, goal_id: Any) -> _Handle:
            """Register a goal in rcl; if it is known, nothing changes."""
            goal = bytes(goal_id.uuid)
            if goal not in self._known:
                info = GoalInfo(goal_id=goal_id, stamp=self._node.get_clock().now().to_msg())
                with self._lock:
                    handle = ServerGoalHandle(self, info, None)
                self._known[goal] = _Handle(handle, info.stamp)
                self._goal_handles[goal] = handle  # rcl asks for their number
            return self._known[goal]

        def begin(self, goal: bytes) -> None:
            handle = self._known[goal].goal
            if handle.status == GoalStatus.STATUS_ACCEPTED:
                handle._update_state(GoalEvent.EXECUTE)

        def cancel(self, goal: bytes) -> None:
            handle = self._known.get(goal)
            if handle is not None and not handle.goal.is_cancel_requested:
                handle.goal._update_state(GoalEvent.CANCEL_GOAL)

        def end(self, goal: bytes, event: Any) -> None:
            handle = self._known.get(goal)
            if handle is not None and handle.goal.is_active:
                handle.goal._update_state(event)

        def publish_feedback(self, goal: bytes, feedback: Any) -> None:
            handle = self._known.get(goal)
            if handle is not None:
                handle.goal.publish_feedback(feedback)

        def respond(self, kind: str, header: Any, response: Any) -> None:
            """Respond to a client that sent a goal, a cancel request or a result request."""
            try:
                getattr(self._handle, f"send_{kind}_response")(header, response)
            except RCLError:
                LOG.warning("a client of an action disappeared before it got its response")

        def destroy(self) -> None:
            for handle in self._known.values():
                handle.goal.destroy()
            self._known.clear()
            self._goal_handles.clear()
            super().destroy()

    return Server
