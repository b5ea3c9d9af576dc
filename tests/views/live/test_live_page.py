"""The live page, in a real browser, with files that grow."""

from __future__ import annotations

import json
import logging
import re
import socket
import struct
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import quote
from urllib.request import Request, urlopen

import pytest
from playwright.sync_api import Page

from dineros.metamodel.files import load
from dineros.metamodel.records import Record, Stop, encode_record
from dineros.views.serving.handle import PageHandle
from dineros.views.traces.merging import merge
from tests.views.browser import Visit, wait_until
from tests.views.samples import CASE_STUDY, run, save_run

NewVisit = Callable[..., Visit]
Serve = Callable[..., PageHandle]


def script() -> list[Record]:
    """Return the records of a run in the order they are written."""
    return [record for _, record in merge({node: scribe.records for node, scribe in run().items()})]


def append(folder: Path, records: Sequence[Record]) -> None:
    for record in records:
        with (folder / f"{record.node}.jsonl").open("a", encoding="utf-8") as file:
            file.write(f"{encode_record(record)}\n")


def steps(page: Page) -> int:
    """Return how many steps the page has; 0 before it has any picture."""
    return int(page.evaluate("globalThis.dinerosTrace ? dinerosTrace.traces[0].length : 0"))


def wait_for_steps(page: Page, number: int) -> None:
    wait_until(page, f"globalThis.dinerosTrace && dinerosTrace.traces[0].length >= {number}")


@pytest.mark.long
def test_a_page_follows_and_catches_up_after_the_server_restarts(
    tmp_path: Path, visit: NewVisit, serve: Serve
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    records = script()
    first, second, third = records[:12], records[12:20], records[20:]
    append(folder, first)
    handle = serve(folder, load(CASE_STUDY))
    one = visit()
    one.loses_its_server = True
    page = one.page
    page.goto(handle.url)
    wait_for_steps(page, 3)
    wait_until(page, "dinerosTrace.cursor === dinerosTrace.traces[0].length - 1")  # it follows the tail
    before = steps(page)
    page.wait_for_selector("#net [data-id=SelectRed]", state="attached")

    handle.stop()
    page.wait_for_selector("#connection[data-state=ended]")
    append(folder, second)  # while nobody serves
    again = serve(folder, load(CASE_STUDY))
    assert again.url == handle.url
    wait_for_steps(page, before + 1)
    page.wait_for_selector("#connection[data-state=live]")
    caught_up = steps(page)

    page.evaluate("dinerosTrace.select(1)")  # as a click does: it stays there
    append(folder, third)
    wait_for_steps(page, caught_up + 1)
    assert page.evaluate("dinerosTrace.cursor") == 1
    page.click("#follow")
    wait_until(page, "dinerosTrace.cursor === dinerosTrace.traces[0].length - 1")
    expected = len([record for record in records if record.event not in ("header", "checkpoint", "start")])
    wait_until(
        page, f"dinerosTrace.traces[0].steps.filter((step) => step.e !== 'checkpoint').length === {expected}"
    )
    # The marking on the net is that after the last step.
    assert page.query_selector("#net [data-id=StateEnd] .tokens circle")
    assert not page.query_selector("#net [data-id=StateGet] .tokens circle")


def test_a_run_that_ends_stays_to_be_read(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    folder, records = tmp_path / "run", script()
    folder.mkdir()
    stopped = {str(record.node) for record in records if record.event == "stop"}
    ends = [
        Stop(sequence=99, time=1100.0, node=node) for node in sorted({str(r.node) for r in records} - stopped)
    ]
    append(folder, records)
    handle = serve(folder)
    one = visit()
    one.loses_its_server = True
    one.page.goto(handle.url)
    wait_for_steps(one.page, 15)
    assert one.page.get_attribute("#connection", "data-state") == "live"
    append(folder, ends[:-1])
    append(folder, ends[-1:])  # and at once, as at the end of a command
    handle.stop()
    one.page.wait_for_selector("#connection[data-state=ended]")
    last = steps(one.page)
    assert one.page.inner_text("#connection") == f"the run has ended · {last} steps"
    assert one.page.evaluate("dinerosTrace.traces[0].text(dinerosTrace.traces[0].length - 1)").endswith(
        "stops"
    )
    one.page.keyboard.press("Home")  # it can still be read
    assert "step 1 of" in one.page.inner_text("#detail")
    one.page.wait_for_timeout(1000)
    assert "lost" not in one.page.inner_text("#head")


def test_a_server_that_leaves_a_run_that_goes_on_says_so(
    tmp_path: Path, visit: NewVisit, serve: Serve
) -> None:
    handle = serve(save_run(tmp_path / "run"))
    one = visit()
    one.loses_its_server = True
    one.page.goto(handle.url)
    wait_for_steps(one.page, 15)
    handle.stop()
    one.page.wait_for_selector("#connection[data-state=ended]")
    assert one.page.inner_text("#connection").startswith("no longer followed · ")


def test_a_connection_that_is_lost_is_called_so(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    handle = serve(save_run(tmp_path / "run"))
    handle._leave = None  # as where its process was killed
    one = visit()
    one.loses_its_server = True
    one.page.goto(handle.url)
    wait_for_steps(one.page, 15)
    handle.stop()
    one.page.wait_for_selector("#connection[data-state=lost]")


def test_a_run_that_begins_after_the_page(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    folder = tmp_path / "later"
    asked = []

    def find_model(header: object) -> None:
        asked.append(header)

    handle = serve(folder, find_model)
    page = visit().page
    page.goto(handle.url)
    page.wait_for_selector("#connection[data-state=live]")
    folder.mkdir()
    append(folder, script())
    wait_for_steps(page, 15)
    assert len(asked) == 1
    assert page.inner_text("#axis") == "wall-clock time"


def test_a_broken_trace_is_said_and_what_was_there_stays(
    tmp_path: Path, visit: NewVisit, serve: Serve
) -> None:
    file = tmp_path / "selector.jsonl"
    run()["selector"].save(file)
    handle = serve(file)
    page = visit().page
    page.goto(handle.url)
    wait_for_steps(page, 3)
    with file.open("a", encoding="utf-8") as stream:
        stream.write("nonsense\n")
    page.wait_for_selector("#connection[data-state=lost]")
    assert "selector.jsonl:8" in page.inner_text("#connection")
    assert steps(page) >= 3
    page.close()  # before the server, which it would miss


def status(url: str, **headers: str) -> int:
    try:
        with urlopen(Request(url, headers=headers), timeout=10) as answer:
            return int(answer.status)
    except HTTPError as error:
        return error.code


def test_only_those_with_the_token_see_anything(tmp_path: Path, serve: Serve) -> None:
    handle = serve(tmp_path)
    base, token = handle.url.split("/?token=")
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+", base)
    assert len(token) >= 32
    assert status(handle.url) == 200
    assert status(f"{base}/") == 403
    assert status(f"{base}/?token={token[:-1]}") == 403
    assert status(f"{base}/?token=%FF") == 403
    assert status(handle.url, Host="evil.example") == 403  # a name that leads here
    for path in ("/selector.jsonl", "/static/trace/page.js", "/docs", "/openapi.json", "/../etc/passwd"):
        assert status(f"{base}{path}?token={token}") == 404


def test_the_stream_wants_token_and_origin(tmp_path: Path, serve: Serve) -> None:
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    handle = serve(tmp_path)
    base, token = handle.url.split("/?token=")
    stream = f"{base.replace('http', 'ws')}/changes?token="

    def first_message(url: str, origin: str | None) -> str:
        with connect(url, origin=origin) as socket:  # type: ignore[arg-type]
            try:
                return str(json.loads(socket.recv(timeout=10))["type"])
            except ConnectionClosed as closed:
                assert closed.rcvd is not None
                return str(closed.rcvd.code)

    assert first_message(stream + token, base) == "snapshot"
    assert first_message(f"{stream}wrong", base) == "4403"
    assert first_message(stream + token, "http://evil.example") == "4403"
    assert first_message(stream + token, None) == "4403"


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (f"number={'9' * 5000}", 400),
        ("number=-1", 400),
        ("number=\u0661", 400),
        ("number=1.5", 400),
        (f"epoch={'a' * 5000}", 400),
        (f"number={'9' * 15}&epoch=x", "snapshot"),
        ("number=&epoch=", "snapshot"),
        ("number=0&number=%FF&unknown=[[[", 400),
    ],
)
def test_what_a_page_says_it_has_seen(
    tmp_path: Path, serve: Serve, capfd: pytest.CaptureFixture[str], asked: str, answer: int | str
) -> None:
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect
    from websockets.typing import Origin

    handle = serve(tmp_path)
    base = Origin(handle.url.split("/?")[0])
    address = f"{handle.url.replace('http', 'ws').replace('/?', '/changes?')}&{quote(asked, safe='=&%')}"
    if answer == 400:
        with pytest.raises(InvalidStatus) as refused, connect(address, origin=base):
            pass
        assert refused.value.response.status_code == 400
        said = bytes(refused.value.response.body or b"")
        assert said.count(b"\n") == 1
        assert said.startswith(b"number has at most 15 digits")
    else:
        with connect(address, origin=base) as stream:
            stream.send('{"type": "nonsense", "number": [[[[')  # what pages say is not listened to
            assert json.loads(stream.recv(timeout=10))["type"] == answer
    handle.stop()
    assert capfd.readouterr().err == ""


@pytest.mark.filterwarnings("ignore:.*(deprecated|remove second)")
@pytest.mark.parametrize("implementation", ["websockets", "websockets-sansio"])
def test_pages_that_go_leave_no_lines(
    tmp_path: Path,
    serve: Serve,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
    implementation: str,
) -> None:
    import uvicorn

    monkeypatch.setattr(uvicorn, "Config", partial(uvicorn.Config, ws=implementation))
    handle = serve(save_run(tmp_path / "run"))
    host, port = handle.url.removeprefix("http://").split("/")[0].split(":")
    request = (
        f"GET {handle.url.partition(port)[2].replace('/?', '/changes?')} HTTP/1.1\r\nHost: {host}:{port}\r\n"
        f"Origin: http://{host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    for number in range(60):
        with socket.create_connection((host, int(port))) as connection:
            connection.sendall(request.encode())
            if number % 2:
                connection.recv(100)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # at once
    assert status(handle.url) == 200
    handle.stop()
    assert capfd.readouterr().err == ""
    assert [record for record in caplog.records if record.levelno > logging.DEBUG] == []


def test_address_is_kept_for_this_user_only(tmp_path: Path, serve: Serve) -> None:
    handle = serve(tmp_path)
    (kept,) = (tmp_path / "state" / "dineros" / "live").iterdir()
    assert kept.stat().st_mode & 0o077 == 0
    assert json.loads(kept.read_text())["token"] in handle.url
    other = serve(tmp_path)  # while the first still runs: neither its port nor its token
    assert other.url.split("=")[1] != handle.url.split("=")[1]
