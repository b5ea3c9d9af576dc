"""What strangers send to bridges: counted, said once, and never their end."""

from __future__ import annotations

import contextlib
import http.server
import logging
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from paho.mqtt.client import Client

from dineros.metamodel.errors import DinerosError
from dineros.runtime.bridges import rest_poll, rest_server
from dineros.runtime.bridges.mqtt import MqttSignals
from dineros.runtime.bridges.rest import RestPoll, RestServer
from dineros.runtime.nets.sources import SourceState
from dineros.runtime.nodes.net import Net
from tests.runtime.bridges.broker import PATIENCE, Broker

ROOT = Path(__file__).resolve().parents[3]

DEEP = '{"value":' + "[" * 5000
DIGITS = '{"value":' + "9" * 5000 + "}"
NONSENSE: list[str | bytes] = [
    DEEP,
    DIGITS,
    b"\xff\xfe",
    "{",
    "",
    "\0",
    '{"value":NaN}',
    '{"value":"\\ud800"}',
    "a\nERROR:b",
]


@pytest.fixture(autouse=True)
def _no_thread_dies(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    died: list[str] = []
    monkeypatch.setattr(threading, "excepthook", lambda args: died.append(repr(args.exc_value)))
    yield
    assert died == []


def the_source(net: Net) -> SourceState:
    (state,) = net.inspect().sources
    return state


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


class TestMqtt:
    def test_nothing_that_arrives_ends_it(
        self, net: Net, broker: Broker, caplog: pytest.LogCaptureFixture
    ) -> None:
        broker.publish("talker/signals/Button", DEEP, retain=True)
        with MqttSignals(net, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            for payload in NONSENSE:
                broker.publish("talker/signals/Button", payload)
            broker.publish("talker/signals/Button", "true")
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)
            state = the_source(net)
        assert state.is_connected
        assert (state.accepted, state.refused, state.failures) == (1, len(NONSENSE) + 1, 0)
        assert "not a truth value" in str(state.last_error)
        assert caplog.text.count("not a truth value") == 1
        assert len(net.inspect().errors) == 1
        assert net.inspect().sources == ()

    def test_large_message_does_not_even_come(self, net: Net, broker: Broker) -> None:
        """The broker is asked to keep it; by MQTT 3.1.1 it comes, and is refused."""
        for version, refused in (("5", 0), ("3.1.1", 1)):
            net.signal("Button").set(False)
            with MqttSignals(net, port=broker.port, version=version) as bridge:  # type: ignore[arg-type]
                assert bridge.wait(PATIENCE)
                broker.publish("talker/signals/Button", b"true".ljust(1_000_000))
                broker.publish("talker/signals/Button", "true")
                net.wait_for(lambda state: state.signals["Button"], PATIENCE)
                assert the_source(net).refused == refused

    def test_wildcards(self, net: Net, broker: Broker) -> None:
        with MqttSignals(net, {"cell/+/door": "Button", "other/#": "Button"}, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            broker.publish("cell/7/door", "true")
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)
            broker.publish("other/a/b", "false")
            net.wait_for(lambda state: not state.signals["Button"], PATIENCE)

    @pytest.mark.parametrize("topic", ["", "a#b", "a/#/b", "a+/b", "a\0b", "x" * 70_000])
    def test_no_topic(self, net: Net, topic: str) -> None:
        with pytest.raises(DinerosError, match="is not an MQTT topic"):
            MqttSignals(net, {topic: "Button"})

    def test_broker_that_breaks_the_protocol(self, net: Net) -> None:
        """Whatever it says, it is tried again."""
        answers = [
            b"\x20\x05\x00\x00\x02\xff\x00",
            b"\x20\x03\x00\x00\x00\x30\xff\xff\xff\xff\xff",
            b"\xff" * 50,
            b"\x20\x01\x00",
            b"",
        ]
        calls: list[None] = []
        with socket.create_server(("127.0.0.1", 0)) as listener:

            def serve() -> None:
                with contextlib.suppress(OSError):
                    for answer in answers:
                        connection, _ = listener.accept()
                        with connection:
                            calls.append(None)
                            connection.recv(1000)
                            connection.sendall(answer)

            thread = threading.Thread(target=serve, daemon=True)
            thread.start()
            with MqttSignals(net, port=listener.getsockname()[1]):
                until(lambda: len(calls) >= 3)
                until(lambda: the_source(net).failures >= 2)
                assert not the_source(net).is_connected
            with contextlib.suppress(OSError):
                listener.shutdown(socket.SHUT_RDWR)
        thread.join(PATIENCE)

    def test_client_that_raises(self, net: Net, broker: Broker, monkeypatch: pytest.MonkeyPatch) -> None:
        """Whatever the MQTT library makes of what it hears, it is tried again."""
        real = Client.loop_forever
        raised: list[None] = []

        def listen(client: Client, **options: Any) -> Any:
            if not raised:
                raised.append(None)
                raise IndexError("nothing left of the packet")
            return real(client, **options)

        monkeypatch.setattr(Client, "loop_forever", listen)
        with MqttSignals(net, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            assert the_source(net).failures == 1


class _Hostile(http.server.BaseHTTPRequestHandler):
    """A web server that answers as its `mode` says."""

    mode = "true"
    asked: list[str]

    def log_message(self, *arguments: Any) -> None:
        pass

    def do_GET(self) -> None:
        self.asked.append(self.path)
        with contextlib.suppress(OSError):
            getattr(self, f"_{self.mode}")()

    def _answer(self, *chunks: bytes, status: int = 200, **headers: str) -> None:
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        for chunk in chunks:
            self.wfile.write(chunk)

    def _true(self) -> None:
        self._answer(b"true")

    def _big(self) -> None:
        self._answer(*[b"x" * 100_000] * 1000)

    def _gzip(self) -> None:
        import gzip

        self._answer(gzip.compress(b"true"), Content_Encoding="gzip")

    def _redirect(self) -> None:
        self._answer(status=302, Location="/elsewhere")

    def _bad_redirect(self) -> None:
        self._answer(status=302, Location="http://[::1")

    def _deep(self) -> None:
        self._answer(DEEP.encode())

    def _charset(self) -> None:
        self._answer(b"\xff", Content_Type="text/plain; charset=nonsense")

    def _drip_body(self) -> None:
        self._answer()
        self._drip()

    def _drip_head(self) -> None:
        self.wfile.write(b"HTTP/1.1 200 OK\r\nX-A: ")
        self._drip()

    def _drip(self) -> None:
        for _ in range(600):
            self.wfile.write(b"x")
            self.wfile.flush()
            time.sleep(0.05)


@pytest.fixture
def hostile() -> Iterator[type[_Hostile]]:
    class Handler(_Hostile):
        asked: list[str] = []
        port = 0

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    Handler.port = server.server_port
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield Handler
    server.shutdown()
    server.server_close()


class TestRestPoll:
    @pytest.mark.long
    def test_nothing_that_is_answered_ends_it(self, net: Net, hostile: type[_Hostile]) -> None:
        url = f"http://127.0.0.1:{hostile.port}/x"  # type: ignore[attr-defined]
        with RestPoll(net, {"Button": url}, period=0.01, timeout=1.0):
            for mode, said in {
                "big": "its answer is larger than",
                "gzip": "its answer is compressed",
                "redirect": "it redirects (302)",
                "bad_redirect": "it redirects (302)",
                "deep": "not a truth value: no JSON",
                "charset": "not a truth value: no UTF-8",
                "drip_body": "no answer in 1 s",
                "drip_head": "no answer in 1 s",
            }.items():
                failures = the_source(net).failures
                hostile.mode = mode
                until(lambda failures=failures: the_source(net).failures >= failures + 2)  # type: ignore[misc]
                assert said in str(the_source(net).last_error)
            hostile.mode = "true"
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)
            until(lambda: the_source(net).is_connected)
        assert "/elsewhere" not in hostile.asked

    def test_answer_that_breaks_the_reader(
        self, net: Net, hostile: type[_Hostile], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Whatever the libraries make of an answer, the server is asked again."""

        def read(answer: bytes, values: object) -> bool:
            raise IndexError("nothing left of the answer")

        url = f"http://127.0.0.1:{hostile.port}/"  # type: ignore[attr-defined]
        with RestPoll(net, {"Button": url}, period=0.01):
            until(lambda: the_source(net).is_connected)
            with monkeypatch.context() as patch:
                patch.setattr(rest_poll, "read_setting", read)
                until(lambda: the_source(net).failures > 1)
                assert "gives no truth value: IndexError: nothing left" in str(the_source(net).last_error)
            until(lambda: the_source(net).is_connected)

    def test_slow_server_holds_up_no_other(self, pair: Net, hostile: type[_Hostile]) -> None:
        """And the bridge is closed while an answer is dripping."""
        hostile.mode = "drip_head"
        slow = f"http://127.0.0.1:{hostile.port}/"  # type: ignore[attr-defined]
        with RestServer(pair, port=0) as server:
            urls = {"Button": slow, "Bell": f"{server.url}/signals/Button"}
            with RestPoll(pair, urls, period=0.01, timeout=60):
                until(lambda: sum(state.accepted for state in pair.inspect().sources) > 3)
        assert "dineros rest poll" not in [thread.name for thread in threading.enumerate()]

    def test_memory(self, hostile: type[_Hostile]) -> None:
        """An answer of 100 MB, and one of as much sent to the server, cost next to nothing."""
        hostile.mode = "big"
        done = subprocess.run(
            [sys.executable, "-c", _MEMORY, str(hostile.port)],  # type: ignore[attr-defined]
            capture_output=True,
            text=True,
            timeout=120,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            check=False,
        )
        assert done.returncode == 0, done.stderr
        grown = [int(megabytes) for megabytes in done.stdout.split()]
        assert len(grown) == 2
        assert max(grown) < 40


_MEMORY = """
import socket, sys, time
from dineros.runtime.bridges.rest import RestPoll, RestServer
from dineros.runtime.nodes.net import Net
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker

def peak():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) // 1024

def failures():
    return sum(state.failures for state in net.inspect().sources)

(part,) = (part for part in split(talker()) if part.node.id == "talker")
with Net(part) as net, RestServer(net, port=0) as server:
    with RestPoll(net, {"Button": server.url + "/signals/Button"}, period=0.01):
        while not sum(state.accepted for state in net.inspect().sources):
            time.sleep(0.01)
    before = peak()
    with RestPoll(net, {"Button": f"http://127.0.0.1:{sys.argv[1]}/"}, period=0.01):
        while failures() < 3:
            time.sleep(0.01)
    after = peak()
    with socket.create_connection(("127.0.0.1", int(server.url.rpartition(":")[2])), timeout=60) as client:
        client.sendall(b"PUT /signals/Button HTTP/1.1\\r\\nHost: localhost\\r\\n")
        client.sendall(b"Content-Length: 100000000\\r\\n\\r\\n")
        try:
            for _ in range(1000):
                client.sendall(b"x" * 100000)
        except OSError:
            pass
    while not any("413" in str(state.last_error) for state in net.inspect().sources):
        time.sleep(0.01)
    print(after - before, peak() - after)
"""


class TestRestServer:
    @pytest.fixture
    def server(self, net: Net) -> Iterator[RestServer]:
        with RestServer(net, port=0) as running:
            yield running

    def test_nothing_that_is_sent_ends_it(
        self, net: Net, server: RestServer, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.WARNING)
        for body in NONSENSE * 2:
            assert httpx.put(f"{server.url}/signals/Button", content=body).status_code == 422
        for name in ("..%2f..%2fetc", "%00", "Button%0a", "a" * 5000, "%ff"):
            answer = httpx.put(f"{server.url}/signals/{name}", content="true")
            assert (answer.status_code, len(answer.content) < 300) == (404, True)
        with socket.create_connection(("127.0.0.1", int(server.url.rpartition(":")[2]))) as client:
            client.sendall(b"\xff" * 1000 + b"\r\n\r\n")
            assert client.recv(12) == b"HTTP/1.1 400"
        assert httpx.put(f"{server.url}/signals/Button", content="true").status_code == 200
        state = the_source(net)
        assert (state.accepted, state.refused) == (1, 2 * len(NONSENSE) + 5)
        assert len(caplog.records) == 2  # one for each status

    def test_clients_that_do_not_go_on(
        self, net: Net, server: RestServer, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(rest_server, "HEADER_TIMEOUT", 0.2)
        address = ("127.0.0.1", int(server.url.rpartition(":")[2]))
        with contextlib.ExitStack() as stack:
            slow = [stack.enter_context(socket.create_connection(address, PATIENCE)) for _ in range(50)]
            for client in slow:
                client.sendall(b"PUT /signals/Button HTTP/1.1\r\nHost: localhost\r\n")
            for client in slow[25:]:
                client.sendall(b"Content-Length: 10\r\n\r\nx")
            assert httpx.get(f"{server.url}/signals", timeout=PATIENCE).status_code == 200
            assert [client.recv(12) for client in slow[:25]] == [b""] * 25
            assert {client.recv(12) for client in slow[25:]} == {b"HTTP/1.1 408"}

    def test_pages_in_a_browser(self, net: Net, server: RestServer) -> None:
        """No page of another origin sets or reads a signal, by whatever name it finds the server."""
        url = f"{server.url}/signals/Button"
        port = server.url.rpartition(":")[2]
        for headers, status in (
            ({"Host": f"evil.example:{port}"}, 421),
            ({"Host": "localhost.evil.example"}, 421),
            ({"Origin": "http://evil.example"}, 403),
            ({"Origin": "null"}, 403),
            ({"Origin": f"https://127.0.0.1:{port}"}, 403),
            ({"Sec-Fetch-Site": "cross-site"}, 403),
            ({"Content-Type": "text/plain;charset=UTF-8"}, 415),
            ({"Content-Type": "application/x-www-form-urlencoded"}, 415),
        ):
            assert httpx.put(url, content="true", headers=headers).status_code == status, headers
            if status != 415:
                assert httpx.get(url, headers=headers).status_code == status
        assert not net.inspect().signals["Button"]
        for headers in (
            {"Host": f"localhost:{port}"},
            {"Host": f"[::1]:{port}"},
            {"Origin": server.url},
            {"Content-Type": "application/json"},
        ):
            assert httpx.put(url, content="true", headers=headers).status_code == 200, headers

    def test_names_of_its_own(self, net: Net) -> None:
        with RestServer(net, port=0, hosts=["Cell.Example"]) as server:
            answer = httpx.get(f"{server.url}/signals", headers={"Host": "cell.example:80"})
            assert answer.status_code == 200
