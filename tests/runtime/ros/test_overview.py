"""`dineros top`: what nodes tell, put together and shown."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from dineros.cli.presentation.overviews import SILENT, json_of, table_of
from dineros.runtime.ros.overview import KeyValue, Overview, circle_of, waits_of
from tests.runtime.ros.conftest import Ros


@dataclass
class Value:
    key: str
    value: str


@dataclass
class Status:
    name: str
    values: list[KeyValue] = field(default_factory=list)
    message: str = ""
    level: bytes = b"\0"
    hardware_id: str = "kitchen"


def said(name: str, part: str, values: dict[str, str], message: str = "", level: int = 0) -> Status:
    pairs: list[KeyValue] = [Value(key, value) for key, value in values.items()]
    return Status(f"{name}: {part}", pairs, message, bytes([level]))


def state(name: str, **more: str) -> Status:
    return said(name, "state", {"state": "running", "firings": "12", "firings per second": "2.5", **more})


def shown(overview: Overview) -> str:
    file = io.StringIO()
    Console(file=file, width=200, color_system=None).print(table_of(overview, 200))
    return file.getvalue()


def test_nodes_that_wait_for_each_other_are_named() -> None:
    now = [0.0]
    overview = Overview(lambda: now[0])
    for name, on, serves in (("/a", "/y", "/x"), ("/b", "/x", "/y"), ("/c", "/x", "/z")):
        waits = said(name, "waits", {"client": f"service {on} 1.2 s"})
        overview.take([state(name), waits, said(name, "services", {serves: "1/1 0"})])
    found = waits_of(overview.nodes())
    assert found["/c"][0].node == "/a"
    assert set(circle_of(found)) == {"/a", "/b"}
    text = shown(overview)
    assert "wait for each other: /" in text
    assert "/c: client waits for the response of /x, which /a serves, 1.2 s" in text
    overview.take([state("/b"), said("/b", "services", {"/y": "0/1 0"})])
    assert circle_of(waits_of(overview.nodes())) == []
    now[0] = SILENT + 1
    overview.take([state("/c")])
    assert shown(overview).count("silent 6 s") == 2


def test_the_fullest_queue_losses_and_concerns_are_shown() -> None:
    overview = Overview()
    queues = said("/b", "queues", {"In": "1/10 /t", "Heard": "9/10 /u"}, "the queue of Heard held 9 of 10", 1)
    overview.take(
        [state("/b", **{"lost subscriber T": "3"}), queues, said("/b", "places", {"P": "2", "Q": "0"})]
    )
    text = shown(overview)
    assert "9/10 Heard" in text
    assert "/b: the queue of Heard held 9 of 10" in text
    assert " 3 " in text
    assert "P 2" in text
    assert "Q" not in text.replace("queue", "")
    (node,) = json_of(overview)["nodes"]
    assert (node["level"], node["application"]) == ("warning", "kitchen")


@given(
    st.lists(
        st.builds(
            Status,
            name=st.text() | st.just("/a: state"),
            values=st.lists(
                st.builds(Value, key=st.text() | st.sampled_from(["firings", "state"]), value=st.text())
            ),
            message=st.text(),
            level=st.binary(max_size=1),
            hardware_id=st.text(),
        )
    )
)
def test_whatever_is_published_steers_no_terminal(statuses: list[Status]) -> None:
    overview = Overview()
    overview.take(statuses)
    text = shown(overview)
    assert all(each.isprintable() or each == "\n" for each in text)
    json.dumps(json_of(overview))


@pytest.mark.long
def test_top_shows_who_waits_for_a_server_that_is_not_there(ros: Ros) -> None:
    ros.node("desk", {"diagnostics_period": 0.1})
    ros.wait(lambda: ros.records("desk", "request"), "asking")
    main = ["-c", "from dineros.cli.main import main; main()", "top", "--once", "--reach", "memory"]
    for seconds in (3, 10, 30):  # discovery takes its time on a busy machine
        listen = ["--seconds", str(seconds), "--domain", ros.environment["ROS_DOMAIN_ID"]]
        top = ros.start("top", *main, *listen)
        if top.popen.wait(90) == 0:
            break
    assert top.popen.returncode == 0, top.output()
    lines = top.output().splitlines()
    assert any(line.startswith("/desk") and "running" in line for line in lines), lines
    assert any(line.startswith("/desk: clientA waits for the response of /weigh, ") for line in lines), lines
    assert sys.executable not in top.output()


NUMBERS = ["1e999", "-1e999", "nan", "inf", ".", "-5", "1e300", "9" * 290, "1_0", "٣", "", "0x10", "1.5"]


@pytest.mark.parametrize("text", NUMBERS)
def test_no_number_ends_it(text: str) -> None:
    """What is told is data: what is not a plausible number counts as 0."""
    overview = Overview()
    numbers = dict.fromkeys(("firings", "firings per second", "failures", "restarts", "lost x"), text)
    values = [
        said("/a", "queues", {"Heard": f"{text}/{text} /t", "Other": f"3/{text} /t"}),
        said("/a", "waits", {"c": f"service /s {text} s", "d": f"room {text} . s"}),
        said("/a", "places", {"P": text}),
        said("/a", "services", {"/s": f"{text}/{text} {text}"}),
    ]
    overview.take([state("/a", **{**numbers, "firings": "1"}), *values])
    (view,) = overview.nodes()
    assert "/a" in shown(overview)
    json.dumps(json_of(overview), allow_nan=False)
    expected = {"1_0": 10, "٣": 3, "1.5": 1}.get(text, 0)
    assert view.lost == expected


def test_a_node_of_the_stranger_is_beside_the_others() -> None:
    overview = Overview()
    overview.take([state("/stranger", **{"lost x": "1e999"})])
    overview.take([state("/mine", **{"lost x": "3"})])
    assert [(view.name, view.lost) for view in overview.nodes()] == [("/mine", 3), ("/stranger", 0)]
