"""What many connections cost a node that serves its signals or metrics: few files; it still answers."""

from __future__ import annotations

import logging
import socket
import ssl
import time
from pathlib import Path
from urllib.request import urlopen

import pytest

from dineros.runtime.bridges import rest_server
from dineros.runtime.bridges.rest import RestServer
from dineros.runtime.bridges.security import Tls
from dineros.runtime.connections import BACKLOG, MOST
from dineros.runtime.nodes.net import Net
from dineros.runtime.ros.metrics import MOST_CONNECTIONS, MetricsServer
from tests.support.programs.crowds import BEGINNINGS, closed, crowd, port_of

FILES = Path("/proc/self/fd")


@pytest.mark.parametrize("beginning", ["half a request", "a request that is refused"])
def test_signals_are_served_in_a_crowd(net: Net, beginning: str, caplog: pytest.LogCaptureFixture) -> None:
    with RestServer(net, port=0) as server:
        before = len(list(FILES.iterdir()))
        with crowd(port_of(server.url), 400, BEGINNINGS[beginning]) as connections:
            assert b"Button" in urlopen(f"{server.url}/signals", timeout=10).read()
            assert len(list(FILES.iterdir())) - before - len(connections) <= MOST + BACKLOG
            assert closed(connections) >= 400 - MOST - BACKLOG
        assert len([each for each in caplog.records if each.levelno > logging.DEBUG]) <= 1


@pytest.mark.parametrize("beginning", ["nothing", "half a handshake"])
def test_signals_are_served_by_tls_in_a_crowd(
    net: Net, beginning: str, server_tls: Tls, certificates: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A connection counts before its handshake, which a stranger need not end."""
    context = ssl.create_default_context(cafile=str(certificates / "ca.pem"))
    with RestServer(net, port=0, tls=server_tls) as server:
        before = len(list(FILES.iterdir()))
        with crowd(port_of(server.url), 400, BEGINNINGS[beginning]) as connections:
            assert b"Button" in urlopen(f"{server.url}/signals", timeout=10, context=context).read()
            assert len(list(FILES.iterdir())) - before - len(connections) <= MOST + BACKLOG
            assert closed(connections) >= 400 - MOST - BACKLOG
        assert len([each for each in caplog.records if each.levelno > logging.DEBUG]) <= 1


def test_a_handshake_has_a_time_limit(
    net: Net, server_tls: Tls, certificates: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rest_server, "HEADER_TIMEOUT", 0.5)
    context = ssl.create_default_context(cafile=str(certificates / "ca.pem"))
    with RestServer(net, port=0, tls=server_tls) as server:
        with crowd(port_of(server.url), 3, BEGINNINGS["half a handshake"]) as connections:
            end = time.monotonic() + 20
            while (number := closed(connections)) < 3 and time.monotonic() < end:
                time.sleep(0.1)
            assert number == 3
        assert b"Button" in urlopen(f"{server.url}/signals", timeout=10, context=context).read()


@pytest.mark.parametrize("beginning", ["nothing", "half a request"])
def test_metrics_are_served_in_a_crowd(beginning: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    server = MetricsServer(port, lambda: "metrics")
    server.start()
    try:
        before = len(list(FILES.iterdir()))
        with crowd(port, 200, BEGINNINGS[beginning]) as connections:
            assert urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10).read() == b"metrics"
            assert len(list(FILES.iterdir())) - before - len(connections) <= 2 * MOST_CONNECTIONS
            assert closed(connections) >= 200 - 2 * MOST_CONNECTIONS
    finally:
        server.close()


def test_a_request_for_metrics_has_a_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """A client that sends a byte from time to time cannot keep its connection."""
    monkeypatch.setattr("dineros.runtime.ros.metrics.PATIENCE", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    server = MetricsServer(port, lambda: "metrics")
    server.start()
    try:
        with crowd(port, 3, BEGINNINGS["half a request"]) as connections:
            end = time.monotonic() + 20
            ended: set[socket.socket] = set()
            while len(ended) < 3 and time.monotonic() < end:
                for each in connections:
                    try:
                        each.sendall(b"a")
                    except OSError:
                        ended.add(each)
                time.sleep(0.2)
            assert len(ended) == 3
        assert urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10).read() == b"metrics"
    finally:
        server.close()
