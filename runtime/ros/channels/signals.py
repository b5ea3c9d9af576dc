"""Input signals in ROS: topics, services and parameters that set them, one by one or together."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, FeatureValueError
from dineros.metamodel.ros_names import SET_SIGNAL, SIGNALS, SIGNALS_WANTED, resource_names
from dineros.runtime.bridges.values import read_setting, read_signals
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import SignalPort
from dineros.runtime.nets.staleness import Expectation, StalenessError, parse_then
from dineros.runtime.ros.channels.latched import LatchedTopic
from dineros.runtime.ros.channels.parameters import declare, signal_parameters, stale_parameters
from dineros.runtime.ros.channels.quality import reliable_quality
from dineros.runtime.ros.process.session import RosError

TOGETHER = f"~/{SIGNALS}"
"""Topic that sets several signals in one step, by JSON in a ``std_msgs/msg/String``: ``{"Red": true}``."""

WANTED = f"~/{SIGNALS_WANTED}"
"""Latched topic on which a starting or restarted node requests its signals: a JSON list of names."""


class RosSignals:
    """Sets the signals of a node from ROS while it is open.

    Raises
    ------
    RosError
        A parameter has an invalid value.
    """

    def __init__(self, node: Any, signals: Sequence[SignalPort], receiver: Receiver) -> None:
        self._receiver = receiver
        self._is_open = True
        self._closing: list[Callable[[], object]] = []
        if not signals:
            return
        self._source = receiver.source(f"ros {node.resolve_topic_name(TOGETHER)}")
        self._source.connected(True)
        self._closing.append(lambda: receiver.remove_source(self._source))
        try:
            self._start_values(node, signals)
            names = resource_names(signal.id for signal in signals)
            for signal in signals:
                if signal.values:
                    self._add_valued(node, signal, names[signal.id])
                else:
                    self._add(node, signal.id, names[signal.id])
            self._add_together(node, {name: s.values for s in signals for name in (s.id, s.name)})
            self._ask(node, [names[signal.id] for signal in signals])
        except BaseException:
            self.close()
            raise

    def _start_values(self, node: Any, signals: Sequence[SignalPort]) -> None:
        values = signal_parameters((signal.id, signal.initial) for signal in signals)
        stale = stale_parameters({signal.id: signal.values for signal in signals})
        for signal in signals:
            start = declare(node, values[signal.id])
            start = start if signal.values else bool(start)
            try:
                signal.require(start)
            except FeatureValueError as error:
                raise RosError(
                    f"the parameter {values[signal.id].name} cannot have the given value: {error}"
                ) from error
            if start != signal.initial:
                self._receiver.signals_changed({signal.id: start}, "parameter")
            after, then = (declare(node, parameter) for parameter in stale[signal.id])
            try:
                expected = Expectation(float(after) or 1.0, parse_then(then))
                expected.require(signal.values)
            except (StalenessError, AttributeError) as error:
                raise RosError(
                    f"the parameter {stale[signal.id][1].name} cannot have the given value: {error}"
                ) from error
            if after:
                self._receiver.signal_expected(signal.id, expected)

    def _add(self, node: Any, id: str, name: str) -> None:
        from std_msgs.msg import Bool
        from std_srvs.srv import SetBool

        def asked(request: Any, response: Any) -> Any:
            if self._is_open:
                self._set({id: bool(request.data)}, "service")
                response.success, response.message = True, f"{id} is {str(bool(request.data)).lower()}"
            else:
                response.message = "the node is not configured"
            return response

        topic = LatchedTopic(
            node, Bool, f"{TOGETHER}/{name}", lambda message: self._set({id: bool(message.data)}, "topic")
        )
        service = node.create_service(SetBool, f"~/{SET_SIGNAL}/{name}", asked)
        self._closing += [topic.close, lambda: node.destroy_service(service)]

    def _add_valued(self, node: Any, signal: SignalPort, name: str) -> None:
        """Let a topic set a signal with values; ROS has no service of its own for this."""
        from std_msgs.msg import String

        def heard(message: Any) -> None:
            try:
                value = read_setting(message.data, signal.values)
            except DinerosError as error:
                self._source.refuse(f"{TOGETHER}/{name}", error)
                return
            self._set({signal.id: value}, "topic")

        self._closing.append(LatchedTopic(node, String, f"{TOGETHER}/{name}", heard).close)

    def _add_together(self, node: Any, known: Mapping[str, Sequence[str]]) -> None:
        from std_msgs.msg import String

        def heard(message: Any) -> None:
            try:
                values = read_signals(message.data, lambda name: known.get(name, ()))
            except DinerosError as error:
                self._source.refuse(TOGETHER, error)
                return
            self._set(values, "topic")

        self._closing.append(LatchedTopic(node, String, TOGETHER, heard).close)

    def _ask(self, node: Any, names: Sequence[str]) -> None:
        """Request all signals from their sources: they may have changed while the node was down."""
        from std_msgs.msg import String

        publisher = node.create_publisher(String, WANTED, reliable_quality(is_kept=True))
        publisher.publish(String(data=json.dumps(names)))
        self._closing.append(lambda: node.destroy_publisher(publisher))

    def _set(self, values: dict[str, SignalSetting], source: str) -> None:
        if not self._is_open:
            return
        try:
            self._receiver.signals_changed(values, source)
        except DinerosError as error:
            self._source.refuse(TOGETHER, error)
            return
        self._source.accept()

    def close(self) -> None:
        """Destroy the topics and services; no signal is set any more."""
        self._is_open = False
        for close in reversed(self._closing):
            close()
        self._closing.clear()
