"""Missed deadlines of subscriptions in runs: in simulated time, replayed and drawn."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, seconds, step
from dineros.metamodel.files import load, save
from tests.cli.conftest import Run


@pytest.fixture
def silent(tmp_path: Path) -> Path:
    """A camera that sends three images, 0.1 s apart, and a watcher that expects one each 0.15 s."""
    model = sym.SystemModel(id="silent", middleware="ros2")
    camera, watcher = node_net(model, "camera"), node_net(model, "watcher")
    shot = place(camera, "Shot")
    step(camera, "Shoot", [place(camera, "Frames", 3)], [shot]).interval = seconds(0.1, 0.1)
    seen, missed = place(watcher, "Seen"), place(watcher, "Missed")
    missed.capacity = 1
    step(watcher, "Look", [seen], [place(watcher, "Images")])
    step(watcher, "Complain", [missed], [place(watcher, "Complaints")])
    topic = sym.TopicChannel(id="Sent", topic="/images", model=model, qos=sym.QualityOfService(deadline=0.15))
    topic.publishers.append(sym.PublisherPort(place=shot, limit=5))
    topic.subscribers.append(sym.SubscriberPort(place=seen, limit=5, missed=missed))
    path = tmp_path / "silent.sym.xmi"
    save(model, path)
    return path


def test_a_silence_is_reported_once_and_the_run_conforms(silent: Path, run: Run, tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    ended = run("run", silent, "--simulate", "--timeout", "3", "--trace", trace)
    assert ended.exit_code == 0, ended.stderr
    records = [json.loads(line) for line in (trace / "watcher.jsonl").read_text().splitlines()]
    assert [each["event"] for each in records if each["event"] in ("take", "miss")] == ["take"] * 3 + ["miss"]
    assert run("conform", silent, trace).exit_code == 0
    assert "watcher misses a message" in run("trace", trace).stdout


def test_a_deadline_that_is_missed_before_any_message_is_no_run_of_the_model(
    silent: Path, run: Run, tmp_path: Path
) -> None:
    trace = tmp_path / "trace"
    run("run", silent, "--simulate", "--timeout", "3", "--trace", trace)
    watcher = trace / "watcher.jsonl"
    records = [json.loads(line) for line in watcher.read_text().splitlines()]
    first = next(number for number, each in enumerate(records) if each["event"] == "take")
    missed = next(each for each in records if each["event"] == "miss")
    records = [*records[:first], missed]
    text = "".join(
        json.dumps({**{k: v for k, v in each.items() if k != "crc"}, "sequence": number}) + "\n"
        for number, each in enumerate(records)
    )
    watcher.write_text(text)
    refused = run("conform", silent, trace)
    assert refused.exit_code == 1
    assert "Missed misses a message (Sent): the deadline of Seen (topic /images) is over" in refused.stdout


@pytest.mark.parametrize("form", ["pnml", "sym.xmi"])
def test_the_place_of_missed_deadlines_is_kept_in_files(silent: Path, tmp_path: Path, form: str) -> None:
    model = load(silent)
    assert isinstance(model, sym.SystemModel)
    save(model, tmp_path / f"again.{form}")
    again = load(tmp_path / f"again.{form}")
    assert isinstance(again, sym.SystemModel)
    (topic,) = again.channels
    assert isinstance(topic, sym.TopicChannel)
    assert topic.subscribers[0].missed is not None
    assert topic.subscribers[0].missed.id == "Missed"
