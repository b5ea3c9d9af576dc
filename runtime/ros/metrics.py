"""Metrics of a node for Prometheus, in its text format, served on 127.0.0.1.

The format has one line for each value (Prometheus, "Exposition formats", version 0.0.4), so it is written
here: the library ``prometheus_client`` would be another dependency on the robot, and count a second time what
the node counts already. Python's web server is imported only if a port is configured.
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from dineros.runtime.nodes.health import Health
from dineros.runtime.ros.process.session import LOG

HOST = "127.0.0.1"
CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
PATIENCE = 5.0
"""Time limit for a client to send its request, in seconds; each connection ends within twice that."""

MOST_CONNECTIONS = 32
"""Maximum number of connections; a further one closes the oldest."""

Sample = tuple[str, str, str, dict[str, str], float]
"""Name, type, help, labels, value."""


def metrics_text(node: str, health: Health | None) -> str:
    """Return the metrics of a node in Prometheus' text format.

    Parameters
    ----------
    node : str
        Its name in ROS, a label of each value.
    health : Health or None
        Its health; None: there was no check yet, and there are no metrics.
    """
    lines: list[str] = []
    told: set[str] = set()
    for name, kind, help, labels, value in sorted(
        _samples(health) if health else (), key=lambda each: each[0]
    ):
        if name not in told:
            told.add(name)
            lines += [f"# HELP dineros_{name} {help}", f"# TYPE dineros_{name} {kind}"]
        shown = ",".join(f'{key}="{_escaped(text)}"' for key, text in {"node": node, **labels}.items())
        lines.append(f"dineros_{name}{{{shown}}} {value:.10g}")
    return "".join(f"{line}\n" for line in lines)


def _samples(health: Health) -> Iterator[Sample]:
    status = health.status
    yield "state", "gauge", "1 for the current state of the node.", {"state": status.state}, 1
    yield "firings_total", "counter", "Firings since the node was started.", {}, health.firings
    yield "failures_total", "counter", "Firings that failed.", {}, health.failures
    yield "restarts_total", "counter", "Number of restarts of the process.", {}, health.restarts
    for place, tokens in health.places.items():
        yield "place_tokens", "gauge", "Tokens of a place.", {"place": place}, tokens
    for queue in health.queues:
        labels = {"place": queue.place, "topic": queue.topic}
        said = "Largest number of waiting messages since the last report."
        yield "queue_waiting", "gauge", said, labels, queue.waiting
        yield "queue_capacity", "gauge", "Proved bound of the messages in the queue.", labels, queue.capacity
    for service, (busy, instances, waiting) in health.servers.items():
        labels = {"service": service}
        yield "service_busy", "gauge", "Requests that are served.", labels, busy
        yield "service_instances", "gauge", "Requests that can be served at the same time.", labels, instances
        yield "service_waiting", "gauge", "Requests that wait in the node.", labels, waiting
    for (channel, where), count in health.drops.items():
        labels = {"channel": channel, "queue": where}
        yield "lost_total", "counter", "Messages that a full queue lost.", labels, count
    for channel, count in health.refused.items():
        yield "refused_total", "counter", "Messages rejected as invalid.", {"channel": channel}, count
    for signal in health.ages:
        labels = {"signal": signal.signal}
        if not signal.values:
            yield "signal", "gauge", "Value of an input signal.", labels, float(bool(signal.value))
        for value in signal.values:
            is_now = float(signal.value == value)
            yield "signal", "gauge", "Value of an input signal.", {**labels, "value": value}, is_now
        yield "signal_stale", "gauge", "1 if the signal is stale.", labels, float(signal.is_stale)
        if signal.age is not None:
            yield "signal_age_seconds", "gauge", "Time since the signal was set.", labels, signal.age
    for load in health.handlers:
        labels = {"transition": load.transition, "handler": load.handler}
        yield "handler_seconds_total", "counter", "Total time of a handler.", labels, load.total
        yield "handler_calls_total", "counter", "Number of runs of a handler.", labels, load.calls
        yield "handler_slow_total", "counter", "Number of runs that exceeded the budget.", labels, load.slow
    for response in health.responses:
        labels = {"callback": response.callback}
        yield (
            "response_seconds_max",
            "gauge",
            "Longest response time since the last report.",
            labels,
            response.longest,
        )
        yield "response_seconds_mean", "gauge", "Mean response time of a callback.", labels, response.mean
        yield "run_seconds_max", "gauge", "Longest run of a callback.", labels, response.work
        yield "callback_runs_total", "counter", "Runs of a callback.", labels, response.runs
        if response.declared is not None and response.declared[1] is not None:
            yield "duration_seconds_declared", "gauge", "Declared duration.", labels, response.declared[1]
            yield "over_duration_total", "counter", "Runs longer than declared.", labels, response.over
        if response.period:
            yield "late_ticks_total", "counter", "Ticks whose callback began late.", labels, response.late
            yield "lost_ticks_total", "counter", "Ticks that were lost.", labels, response.lost
    # Several parts may wait for the same thing: the longest wait is reported.
    waits: dict[tuple[str, str, str], float] = {}
    for wait in health.waits:
        key = wait.element, wait.kind, wait.on
        waits[key] = max(waits.get(key, 0.0), wait.seconds)
    for (element, kind, on), seconds in waits.items():
        labels = {"element": element, "kind": kind, "on": on}
        yield "waiting_seconds", "gauge", "Time for which something has waited.", labels, seconds
    concerns = {(concern.budget, concern.element) for concern in health.concerns}
    for budget, element in sorted(concerns):
        labels = {"budget": budget, "element": element}
        yield "over_budget", "gauge", "1 for each exceeded budget.", labels, 1


def _escaped(text: str) -> str:
    text = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return text.encode("utf-8", "backslashreplace").decode()


class MetricsServer:
    """Serves ``GET /metrics`` on 127.0.0.1, on its own threads.

    Parameters
    ----------
    port : int
        Port to listen on.
    text : callable
        Returns the response; from any thread.
    """

    def __init__(self, port: int, text: Callable[[], str]) -> None:
        self._port = port
        self._text = text
        self._server: Any = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start listening; if that fails, the error is logged and the node continues without metrics."""
        from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

        text, names = self._text, {f"{host}:{self._port}" for host in (HOST, "localhost")}
        connections: dict[socket.socket, float] = {}

        def end(connection: socket.socket) -> None:
            connections.pop(connection, None)
            with contextlib.suppress(OSError):  # then its thread ends
                connection.shutdown(socket.SHUT_RDWR)

        class Answers(BaseHTTPRequestHandler):
            timeout = PATIENCE

            def do_GET(self) -> None:
                # A web page whose host name points to this machine must not read it (DNS rebinding).
                if self.headers.get("Host", "") not in names:
                    self.send_error(403)
                elif self.path.partition("?")[0] != "/metrics":
                    self.send_error(404)
                else:
                    content = text().encode()
                    self.send_response(200)
                    self.send_header("Content-Type", CONTENT_TYPE)
                    self.send_header("Content-Length", str(len(content)))
                    self.end_headers()
                    self.wfile.write(content)

            def log_message(self, format: str, *values: object) -> None:
                LOG.debug("metrics: " + format, *values)

        class Server(ThreadingHTTPServer):
            daemon_threads = True

            def process_request(self, request: Any, client_address: Any) -> None:
                connections[request] = time.monotonic()
                if len(connections) > MOST_CONNECTIONS:
                    end(next(iter(connections)))
                super().process_request(request, client_address)

            def service_actions(self) -> None:
                # Each read has a time limit; a client that sends one byte every second never reaches it.
                for request, since in list(connections.items()):
                    if time.monotonic() - since > PATIENCE:
                        end(request)

            def shutdown_request(self, request: Any) -> None:
                connections.pop(request, None)
                super().shutdown_request(request)

            def handle_error(self, request: object, client_address: object) -> None:
                LOG.debug("a request for metrics failed", exc_info=True)

        try:
            self._server = Server((HOST, self._port), Answers)
        except OSError as error:
            LOG.error("no metrics on %s:%d: %s", HOST, self._port, error)
            return
        LOG.info("metrics on http://%s:%d/metrics", HOST, self._port)
        self._thread = threading.Thread(
            target=self._server.serve_forever, name="dineros metrics", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        server, self._server = self._server, None
        if server is not None:
            server.shutdown()
            server.server_close()
        if self._thread is not None:
            self._thread.join(PATIENCE)
