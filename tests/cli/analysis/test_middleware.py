"""`--middleware` with every command that flattens a model, and what reports and notes say of it."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import load, save
from tests.cli.conftest import Run
from tests.histories.test_figures import periodic

SAYS = "by the rules of ros2: writer, reader and request histories, capacities\n"
RUNS = "runs by the rules of ros2, whose queues ROS 2 has; the model says ros1"
OTHER = "by the rules of ros1, but ROS 2 has other queues"


@pytest.fixture(params=["ros1", "ros2"])
def own(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Return the file of a model that says its middleware."""
    model = periodic(2)
    model.middleware = request.param
    path = tmp_path / "periodic.sym.xmi"
    save(model, path)
    return path


def test_statespace_obeys_the_option(run: Run, own: Path) -> None:
    result = run("statespace", own, "--signals", "none", "--middleware", "ros2", "--json")
    report = json.loads(result.stdout)
    assert (report["middleware"], report["states"], report["complete"]) == ("ros2", 144, True)
    assert result.stderr.endswith(f"{own}: {SAYS}")
    result = run("statespace", own, "--middleware", "ros1", "--json")
    assert result.exit_code == 3
    assert "middleware" not in json.loads(result.stdout)
    assert SAYS not in result.stderr


def test_a_model_decides_without_the_option(run: Run, own: Path) -> None:
    is_ros2 = 'middleware="ros2"' in own.read_text()
    assert run("statespace", own).exit_code == (0 if is_ros2 else 3)


def test_check_speaks_of_histories(run: Run, own: Path) -> None:
    result = run("check", own, "--middleware", "ros2", "--witnesses")
    assert result.exit_code == 1
    assert "error: writer history of Said for Heard (topic /talk) can overflow" in result.stdout
    assert "error: reader history of Heard (topic /talk) can overflow" in result.stdout
    assert "  Said publishes a message on topic /talk\n" in result.stdout
    assert "  reader history of Heard (topic /talk) loses a message\n" in result.stdout


def test_find_verify_and_reduce(run: Run, own: Path, tmp_path: Path) -> None:
    ros2 = ("--middleware", "ros2")
    assert run("find", own, "--marking", "Heard >= 2", *ros2).exit_code == 1
    assert run("find", own, "--enabled", "talk.reader.Heard.drop", *ros2).exit_code == 0
    assert run("verify", own, "--ctl", "AG (Heard <= 1)", *ros2).exit_code == 0
    reduced = tmp_path / "reduced.pnml"
    assert run("reduce", own, "-o", reduced, "--signals", "none", *ros2).exit_code == 0
    assert run("statespace", reduced).exit_code == 0


@pytest.mark.long
def test_sweep(run: Run, own: Path, tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    vary = ("--vary", "talk.publisher.Said.limit,talk.subscriber.Heard.limit=1,2")
    result = run(
        "sweep", own, *vary, "--signals", "none", "--workers", "1", "-o", table, "--middleware", "ros2"
    )
    assert result.exit_code == 0
    with table.open(encoding="utf-8") as file:
        assert [row["states"] for row in csv.DictReader(file)] == ["64", "144"]


def test_flatten_names_the_rules(run: Run, own: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.pnm"
    result = run("flatten", own, "-o", output, "--middleware", "ros2", "--json")
    assert json.loads(result.stdout)["middleware"] == "ros2"
    explained = run("flatten", own, "--middleware", "ros2", "--explain", "talk.writer.Said.Heard.Load")
    assert explained.stdout.startswith("talk.writer.Said.Heard.Load: place made by R2 as queue.load from")
    free = run("flatten", own, "--middleware", "ros2", "--explain", "Said.free")
    assert free.stdout.startswith("Said.free: place made by B2 as bound.free from publisher port at Said")


def test_a_plain_net_has_no_middleware(run: Run, tmp_path: Path) -> None:
    net = tmp_path / "net.net"
    net.write_text("net n\npl p (1)\ntr t p ->\n", encoding="utf-8")
    result = run("statespace", net, "--middleware", "ros2")
    assert result.exit_code == 2
    assert result.stderr == f"{net}: middleware: the model is not a system model (leave it out)\n"


def test_ports_that_do_not_match(run: Run, own: Path) -> None:
    wanted = ("--set", "talk.subscriber.Heard.qos.durability=transientLocal")
    result = run("check", own, "--middleware", "ros2", *wanted)
    assert (
        "warning: Heard receives no message of Said (topic /talk): the publisher's durability is volatile, "
        "and the subscriber requests transientLocal; to fix it, "
        "set talk.publisher.Said.qos.durability=transientLocal or "
        "talk.subscriber.Heard.qos.durability=volatile [ports-not-matched]\n"
    ) in result.stdout
    fixed = ("--set", "talk.publisher.Said.qos.durability=transientLocal")
    assert "ports-not-matched" not in run("check", own, "--middleware", "ros2", *wanted, *fixed).stdout
    assert "[ports-match]" in run("validate", own, *wanted).stdout


def test_a_port_begins_with_its_topics_quality_of_service(run: Run, own: Path, tmp_path: Path) -> None:
    output = tmp_path / "changed.sym.xmi"
    settings = ("talk.qos.reliability=bestEffort", "talk.publisher.Said.qos.deadline=2")
    result = run("convert", own, "-o", output, *(part for text in settings for part in ("--set", text)))
    assert result.exit_code == 0
    model = load(output)
    assert isinstance(model, sym.SystemModel)
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    quality = channel.publishers[0].qos
    assert quality is not None
    assert (str(quality.reliability), quality.deadline) == ("bestEffort", 2.0)


def test_generate_says_where_ros_2_differs_from_the_rules(run: Run, own: Path, tmp_path: Path) -> None:
    made = ("generate", own, "-o", tmp_path / "workspace", "--set", "logger.package=periodic_logger")
    assert f"{own}: {OTHER}" in run(*made, "--middleware", "ros1").stderr
    assert OTHER not in run("run", own, "--local", "--timeout", "0.1", "--middleware", "ros1").stderr
    result = run(*made, "--middleware", "ros2")
    assert (result.exit_code, OTHER in result.stderr) == (0, False)


def test_what_is_generated_for_ros_2_has_its_rules(run: Run, own: Path, tmp_path: Path) -> None:
    """Without --middleware, whatever the model says; the workspace names it, and so will its traces."""
    says_ros1 = 'middleware="ros2"' not in own.read_text()
    workspace = tmp_path / "workspace"
    result = run("generate", own, "-o", workspace, "--set", "logger.package=periodic_logger")
    assert (result.exit_code, f"{own}: {RUNS}" in result.stderr) == (0, says_ros1)
    manifest = json.loads((workspace / ".dineros/manifest.json").read_text())
    named = "middleware=ros2" in manifest["settings"]
    assert named is says_ros1
    assert 'middleware="ros2"' in next(workspace.rglob("*.rtm.xmi")).read_text()


@pytest.mark.long
def test_conform_takes_the_rules_that_the_run_recorded(run: Run, own: Path, tmp_path: Path) -> None:
    """Also where other settings are given; --middleware holds instead."""
    trace = tmp_path / "trace"
    more = ("--set", "talk.publisher.Said.limit=3")
    ran = ("--simulate", "--seed", "1", "--timeout", "3", "--trace", trace, "--middleware", "ros2")
    assert run("run", own, *ran, *more).exit_code == 0
    for given in ((), more):
        result = run("conform", own, trace, *given)
        assert result.exit_code == 0, result.stdout + result.stderr
        assert SAYS in result.stderr
    assert SAYS not in run("conform", own, trace, *more, "--middleware", "ros1").stderr


@pytest.mark.long
def test_a_run_is_replayed_by_the_rules_that_it_obeys(run: Run, own: Path, tmp_path: Path) -> None:
    for middleware in ("ros1", "ros2"):
        trace = tmp_path / middleware
        rules = ("--middleware", middleware)
        stopped = run(
            "run", own, "--simulate", "--seed", "1", "--timeout", "3", "--trace", trace, "--monitor", *rules
        )
        assert stopped.exit_code == 0, stopped.stderr
        assert "conformance: conforms" in stopped.stdout
        merged = tmp_path / f"{middleware}.jsonl"
        result = run("conform", own, trace, "--invariant", "Heard <= 1", "-o", merged)
        assert result.exit_code == (0 if middleware == "ros2" else 1), result.stdout + result.stderr
        assert (SAYS in result.stderr) is (middleware == "ros2")


def test_suggested_depths(run: Run, tmp_path: Path) -> None:
    """Three messages, of which all may wait in either history."""
    model = periodic(2)
    (page, _) = model.pages
    tick = next(node for node in page.objects if isinstance(node, pn.Transition))
    flow(sym.Place(id="Stock", tokens=3, page=page), tick)
    path = tmp_path / "three.sym.xmi"
    save(model, path)
    result = run("check", path, "--suggest-capacities")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[:2] == [
        "reader history of Heard (topic /talk): has 2, needs 3",
        "writer history of Said for Heard (topic /talk): has 2, needs 3",
    ]
    depths = ("--set", "talk.publisher.Said.limit=3", "--set", "talk.subscriber.Heard.limit=3")
    assert "queue-overflow" not in run("check", path, *depths).stdout
