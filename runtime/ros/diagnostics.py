"""Publishes the health of a node: on ``/diagnostics`` once a period, and to Prometheus on request.

It checks the node between two firings, on the node's thread, and builds messages only while there are
subscribers. No error here ends the node.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from dineros.metamodel.clauses import SignalSetting, setting_text
from dineros.runtime.nodes.health import Health, HealthWatch
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.responses import ResponseTime
from dineros.runtime.nodes.status import Status
from dineros.runtime.ros.channels.parameters import DIAGNOSTICS_PERIOD, METRICS_PORT, declare
from dineros.runtime.ros.metrics import MetricsServer, metrics_text
from dineros.runtime.ros.process.session import LOG
from dineros.runtime.scheduling.timers import Timer

TOPIC = "/diagnostics"

Values = Iterable[tuple[str, object]]

_FINE = ("running", "ended")


class Diagnostics:
    """Monitors one node and publishes its health.

    Attributes
    ----------
    latest : Health or None
        The last known health; read from any thread.
    """

    def __init__(self, node: Any, net: Net) -> None:
        self._node = node
        self._net = net
        self._watch = HealthWatch(net.core)
        self._period = 0.0
        self._timer = Timer()
        self._publisher: Any = None
        self._server: MetricsServer | None = None
        self._lock = threading.Lock()
        self._has_failed = False
        self.latest: Health | None = None

    def open(self) -> None:
        """Start monitoring, according to the node's parameters."""
        self._period = float(declare(self._node, DIAGNOSTICS_PERIOD))
        port = int(declare(self._node, METRICS_PORT))
        if self._period <= 0:
            return
        self._publisher = self._make_publisher()
        if port:
            name = self._node.get_fully_qualified_name()
            self._server = MetricsServer(port, lambda: metrics_text(name, self.latest))
            self._server.start()
        self._timer = self._net.core.loop.steady_timers.call_later(0.0, self._tick)

    def _make_publisher(self) -> Any:
        """Return the publisher; None: the messages are not installed."""
        try:
            from diagnostic_msgs.msg import DiagnosticArray
        except ImportError:
            LOG.warning("reports on %s are disabled: install the ROS package diagnostic_msgs", TOPIC)
            return None
        from rclpy.event_handler import PublisherEventCallbacks

        no_events = PublisherEventCallbacks(use_default_callbacks=False)  # events cost time at each message
        return self._node.create_publisher(DiagnosticArray, TOPIC, 10, event_callbacks=no_events)

    def _tick(self) -> None:
        """Check, publish, and schedule the next check after a period; on the node's thread."""
        self._timer = self._net.core.loop.steady_timers.call_later(self._period, self._tick)
        try:
            self.latest = self._watch.look()
            self._publish(self.latest)
        except Exception:
            if not self._has_failed:  # log it once, not in each period
                LOG.exception("the node cannot determine its state")
            self._has_failed = True

    def said(self, status: Status) -> None:
        """Publish a changed status at once; from any thread, even while a handler blocks the node."""
        latest = self.latest
        if latest is not None:
            try:
                self._publish(replace(latest, status=status))
            except Exception:
                LOG.debug("a change of the status is not reported on %s", TOPIC, exc_info=True)

    def _publish(self, health: Health) -> None:
        with self._lock:
            if self._publisher is None or not self._publisher.get_subscription_count():
                return
            self._publisher.publish(self._message(health))

    def _message(self, health: Health) -> Any:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        name = self._node.get_fully_qualified_name()
        levels = {"ok": DiagnosticStatus.OK, "warn": DiagnosticStatus.WARN, "error": DiagnosticStatus.ERROR}
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        for part, (level, text, values) in parts_of(health).items():
            message.status.append(
                DiagnosticStatus(
                    level=levels[level],
                    name=f"{name}: {part}",
                    message=text,
                    hardware_id=self._net.structure.ports.model,
                    values=[KeyValue(key=key, value=str(value)) for key, value in values],
                )
            )
        return message

    def close(self) -> None:
        """Stop monitoring."""
        self._timer.cancel()
        server, self._server = self._server, None
        if server is not None:
            server.close()
        with self._lock:
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            self._node.destroy_publisher(publisher)


def parts_of(health: Health) -> Mapping[str, tuple[str, str, list[tuple[str, object]]]]:
    """Return the diagnostics of a node: part -> level, text, values; parts without content are left out.

    ========  =====================================================================
    state     its state, firings, failures, restarts, losses
    places    tokens of each place
    queues    messages that waited, the proved capacity, and the topic
    services  requests served, instances, and requests that wait
    signals   value and age
    handlers  the longest and the mean time, and the budget
    callbacks response times, time of a run and its declared duration, late and lost ticks
    waits     which part waits for what, and for how long
    ========  =====================================================================
    """
    words: dict[str, list[str]] = {}
    for concern in health.concerns:
        words.setdefault(concern.budget, []).append(concern.text)
    parts: dict[str, tuple[str, str, list[tuple[str, object]]]] = {"state": _state(health)}
    told: tuple[tuple[str, str, list[tuple[str, object]]], ...] = (
        ("places", "place-limit", list(health.places.items())),
        ("queues", "queue-fill", [(q.place, f"{q.waiting}/{q.capacity} {q.topic}") for q in health.queues]),
        ("services", "", [(name, "{}/{} {}".format(*load)) for name, load in health.servers.items()]),
        ("signals", "signal-age", [(s.signal, _signal(s.value, s.age)) for s in health.ages]),
        ("handlers", "handler-time", _handlers(health)),
        ("callbacks", "callback-time", [(each.callback, response_text(each)) for each in health.responses]),
        ("waits", "", [(w.element, f"{w.kind} {w.on} {w.seconds:.1f} s") for w in health.waits]),
    )
    for part, budget, values in told:
        if values:
            said = "; ".join(words.get(budget, ()))
            parts[part] = ("warn" if said else "ok", said, values)
    return parts


def _state(health: Health) -> tuple[str, str, list[tuple[str, object]]]:
    status = health.status
    is_idle = status.state == "halted" and "not active" in (status.reason or "")
    level = "ok" if status.state in _FINE or is_idle else "error"
    values: list[tuple[str, object]] = [
        ("state", status.state),
        ("firings", health.firings),
        ("firings per second", f"{health.rate:.3g}"),
        ("failures", health.failures),
        ("restarts", health.restarts),
        ("last error", "" if status.error is None else status.error.error),
    ]
    values += [(f"lost {queue} {channel}", count) for (channel, queue), count in health.drops.items()]
    values += [(f"refused {channel}", count) for channel, count in health.refused.items()]
    return level, status.state if status.reason is None else f"{status.state}: {status.reason}", values


def _signal(value: SignalSetting, age: float | None) -> str:
    return f"{setting_text(value)} {'never' if age is None else f'{age:.1f} s'}"


def response_text(time: ResponseTime) -> str:
    """Return the measured times of a callback, and those that its model declares."""
    said = f"response {time.longest:.3g} s, mean {time.mean:.3g} s, greatest {time.greatest:.3g} s"
    said += f", run {time.work:.3g} s"
    if time.declared is not None:
        least, most = time.declared
        bounds = f"{least:g} s to {most:g} s" if most is not None else f"from {least:g} s"
        said += f" of declared {bounds}" + (f", {time.over} too long" if most is not None else "")
    if time.period:
        said += f", {time.late} late and {time.lost} lost ticks of {time.period:g} s"
    return said


def _handlers(health: Health) -> list[tuple[str, object]]:
    return [
        (
            f"{each.transition} {each.handler}",
            f"{each.longest:.3g} s, mean {each.mean:.3g} s"
            + (f", budget {each.budget:g} s, {each.slow} too slow" if each.budget is not None else ""),
        )
        for each in health.handlers
    ]
