"""``dineros latency``: bounds of chains and of everything, as text and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import files, sym
from dineros.metamodel.elements import find
from tests.cli.conftest import Run
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """Return a timer of 4 hundredths of a second, whose messages a logger that is too slow loses."""
    path = tmp_path / "robot.sym.xmi"
    files.save(model_of(COUNTED[2].system, 0.01), path)
    return path


def test_a_chain(run: Run, robot: Path) -> None:
    found = run("latency", robot, "--from", "tick", "--to", "log")
    assert found.exit_code == 0
    assert found.stdout.splitlines()[-2:] == [
        "tick to log: 0.02 to 0.15 s, an instance can be lost",
        "reaction time up to 0.2 s, data age up to 0.2 s",
    ]
    answer = json.loads(run("latency", robot, "--from", "tick", "--to", "log", "--json").stdout)
    assert answer == {
        "model": str(robot),
        "least": 0.02,
        "greatest": 0.15,
        "lost": True,
        "reaction": 0.2,
        "age": 0.2,
        "exact": True,
    }


def test_everything(run: Run, robot: Path) -> None:
    answer = json.loads(run("latency", robot, "--json").stdout)
    assert answer["callbacks"] == {
        "tick": {"least": 0.0, "greatest": 0.01, "exact": True, "starves": False},
        "log": {"least": 0.02, "greatest": 0.15, "exact": True, "starves": False},
    }
    assert answer["readers"] == {"log.heard": {"longest": 2, "overflow": True}}
    assert answer["timers"] == {"tick": {"lostTicks": False}}
    lines = run("latency", robot).stdout.splitlines()
    assert "callback log: 0.02 to 0.15 s" in lines and "timer tick: loses no tick" in lines
    assert "reader log.heard: at most 2 waiting, can overflow" in lines


def test_what_others_can_keep_waiting(run: Run, tmp_path: Path) -> None:
    work = {"node": "n", "offset": 0, "group": "default"}
    callbacks = [
        {"name": "fast", "period": 1, "script": [["work", 1, 1]], **work},
        {"name": "slow", "period": 4, "script": [["work", 1, 1]], **work},
    ]
    system = {"nodes": {"n": {"threads": 1}}, "latency": {}, "chains": [], "callbacks": callbacks}
    path = tmp_path / "busy.sym.xmi"
    files.save(model_of(system), path)
    found = run("latency", path)
    assert found.exit_code == 3
    assert "callback slow: at least 1 s, can wait without end" in found.stdout.splitlines()
    assert json.loads(run("latency", path, "--json").stdout)["callbacks"]["slow"]["starves"] is True


def test_least_depths(run: Run, robot: Path) -> None:
    found = run("latency", robot, "--depths", "--set", "log.duration.latest=0.04")
    assert (found.exit_code, found.stdout) == (0, "reader log.heard: least depth 1; it has 2\n")
    answer = json.loads(run("latency", robot, "--depths", "--json").stdout)
    reason = "a depth of 64 does not suffice"
    assert answer["depths"] == {"log.heard": {"depth": 2, "least": None, "reason": reason}}
    assert run("latency", robot, "--depths", "--bounds").exit_code == 2


def test_stored_bounds(run: Run, robot: Path) -> None:
    model = files.load(robot)
    assert isinstance(model, sym.SystemModel)
    texts = {
        "Fast": "tick to log within 0.1",
        "Slow": "tick to log within 0.15",
        "Bad": "log to tick within 1",
    }
    model.properties.extend(sym.Property(id=name, text=text) for name, text in texts.items())
    files.save(model, robot)
    lines = run("check", "--time", robot).stdout.splitlines()
    assert lines[0].startswith(
        "error: property Fast does not hold: tick to log within 0.1; it takes up to 0.15 s"
    )
    assert lines[1].startswith("error: property Bad cannot be decided: no data flows from callback log")
    found = json.loads(run("check", "--time", "--json", robot).stdout)
    proved = "property Slow holds: tick to log within 0.15 (at most 0.15 s; an instance can be lost)"
    assert proved in found["proved"]
    assert found["findings"][0]["witness"]["steps"][-1]["time"]["at"] == 0.47
    without = json.loads(run("check", "--json", robot).stdout)
    assert len(without["unknown"]) == len(texts)
    assert all("use --time" in each for each in without["unknown"])

    verified = run("verify", "--time", robot, "Fast")
    assert verified.exit_code == 1
    assert verified.stdout.startswith(
        "violated: Fast: tick to log within 0.1 (it takes up to 0.15 s, counted"
    )
    assert run("verify", "--time", robot, "Slow").exit_code == 0
    confirmed = run("verify", "--time", "--confirm", robot, "Slow")
    assert confirmed.exit_code == 0 and "only one engine decides latencies" in confirmed.stderr
    assert run("verify", robot, "Slow").exit_code == 3
    assert run("verify", "--time", robot, "Bad").exit_code == 2


ASSUMED = (
    "note: these are safe bounds that may never be reached; they assume that each thread of an executor has "
    "a processor of its own, and nothing outside of the model publishes"
)
LOST = "data on the way may be lost"
FULL = "bounds allow 4 waiting messages, and its depth is 2"


def test_bounds(run: Run, robot: Path) -> None:
    found = run("latency", robot, "--bounds")
    assert found.exit_code == 0
    assert found.stdout.splitlines() == [
        "callback tick: at least 0 s, at most 0.01 s",
        "callback log: at least 0.02 s, at most 0.15 s",
        "reader log.heard: at most 2 waiting; it is unknown whether it can overflow",
        f"    open: {FULL}",
        "timer tick: loses no tick",
        ASSUMED,
    ]
    answer = json.loads(run("latency", robot, "--bounds", "--json").stdout)
    assert answer["callbacks"]["log"] == {"least": 0.02, "greatest": 0.15, "exact": False}
    assert answer["readers"] == {"log.heard": {"longest": 2, "overflow": None, "reason": FULL}}
    assert answer["exact"] is False and "processor" in answer["assumes"]


def test_bounds_of_a_chain(run: Run, robot: Path) -> None:
    found = run("latency", robot, "--bounds", "--from", "tick", "--to", "log")
    assert found.exit_code == 0
    assert found.stdout.splitlines() == [
        "tick to log: at least 0.02 s, at most 0.17 s; it is unknown whether an instance can be lost",
        f"reaction time and data age not known: {LOST}",
        ASSUMED,
    ]
    answer = json.loads(run("latency", robot, "--bounds", "--from", "tick", "--to", "log", "--json").stdout)
    assert (answer["greatest"], answer["lost"], answer["exact"]) == (0.17, None, False)
    assert answer["reasons"] == {"lost": "a history on the way may overflow", "reaction": LOST, "age": LOST}


@pytest.mark.parametrize("options", [("--timeout", "8"), ()], ids=["with a limit", "without"])
def test_bounds_where_the_search_does_not_end(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    """Thirty timers in as many nodes have more states than can be explored."""
    monkeypatch.setattr("dineros.cli.commands.analysis.latency.EXACT_SECONDS", 3.0)
    callbacks = [
        {
            "name": f"tick{number}", "node": f"n{number}", "group": "default", "period": 7 + number,
            "offset": "any", "script": [["work", 1, 2]],
        }
        for number in range(30)
    ]  # fmt: skip
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    path = tmp_path / "large.sym.xmi"
    files.save(model_of({"nodes": nodes, "latency": {}, "chains": [], "callbacks": callbacks}, 0.01), path)
    found = run("latency", path, *options)
    assert found.exit_code == 0
    lines = found.stdout.splitlines()
    assert (
        "callback tick7: at least 0.01 s, at most 0.02 s" in lines and "timer tick7: loses no tick" in lines
    )
    assert any(line.startswith("note: exact times are not known: time ran out") for line in lines)
    assert ASSUMED in lines


def test_bounds_where_too_many_messages_are_on_their_way(run: Run, tmp_path: Path) -> None:
    """A hundred messages at once have no clocks of their own; bounds need none."""
    callbacks = [
        {
            "name": "tick", "node": "a", "group": "default", "period": 1, "offset": 0,
            "script": [["work", 0, 0], ["publish", "t"]],
        },
        {
            "name": "log", "node": "b", "group": "default", "topic": "t", "depth": 9,
            "script": [["work", 0, 0]],
        },
    ]  # fmt: skip
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    path = tmp_path / "far.sym.xmi"
    system = {"nodes": nodes, "latency": {"t": (100, 103)}, "chains": [], "callbacks": callbacks}
    files.save(model_of(system, 0.01), path)
    found = run("latency", path, "--from", "tick", "--to", "log")
    assert found.exit_code == 0
    lines = found.stdout.splitlines()
    assert lines[0] == "tick to log: at least 1 s, at most 1.03 s"
    assert "messages of topic t can be on their way at once" in lines[2]


def test_callbacks_without_response_times_are_named(run: Run) -> None:
    """Nothing follows when goals and results call a callback; the answer does not hide that."""
    found = run("latency", EXAMPLES / "sorting_actions" / "cell_timed.sym.xmi", "--bounds")
    (note,) = [each for each in found.stdout.splitlines() if "not computed" in each]
    assert note.startswith("note: response times are not computed for ") and "(goal)" in note
    assert "not computed" not in run("latency", EXAMPLES / "callbacks" / "sensor_timed.sym.xmi").stdout


def test_a_page_and_a_run(run: Run, robot: Path, tmp_path: Path) -> None:
    page, trace = tmp_path / "report.html", tmp_path / "run.jsonl"
    found = run("latency", robot, "-o", page)
    assert found.exit_code == 0 and found.stdout.splitlines()[-1] == f"{robot} -> {page}"
    shown = page.read_text()
    assert "<td>0 to 0.01 s</td>" in shown and "<td>0.02 to 0.15 s</td>" in shown
    assert "callback log takes 0.15 s, counted from 0.32 s" in shown and "time of the schedule" in shown
    assert 'class="error">125.0 %' in shown

    assert run("latency", robot, "--from", "tick", "--to", "log", "-o", trace).exit_code == 0
    assert json.loads(trace.read_text().splitlines()[-1])["time"] == 0.47
    assert run("trace", trace, "-o", tmp_path / "run.html").exit_code == 0
    chain = run("latency", robot, "--from", "tick", "--to", "log", "--json", "-o", page)
    assert json.loads(chain.stdout)["greatest"] == 0.15
    assert "tick to log: 0.02 to 0.15 s, an instance can be lost" in page.read_text()
    bounds = run("latency", robot, "--bounds", "-o", page)
    assert bounds.exit_code in (0, 3) and "they assume that each thread" in page.read_text()


def test_what_is_open_ends_with_status_3(run: Run, tmp_path: Path) -> None:
    model, path = model_of(COUNTED[1].system, 0.01), tmp_path / "open.sym.xmi"
    page = find(model, "log")
    assert isinstance(page, sym.CallbackPage)
    page.duration = None
    files.save(model, path)
    found = run("latency", path, "--from", "tick", "--to", "log")
    assert found.exit_code == 3
    assert found.stdout.splitlines()[-2:] == [
        "tick to log: at least 0 s, an instance can be lost",
        "no bound for tick to log: the duration of callback log is not given",
    ]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--from", "tick"), "--from and --to must be given together"),
        (("-o", "run.jsonl"), "-o writes a run with --from and --to"),
        (("--from", "tick", "--to", "tock"), "no callback or topic is called tock"),
        (("--from", "log", "--to", "tick"), "no data flows from callback log to callback tick"),
    ],
)
def test_wrong_questions_end_in_a_line(run: Run, robot: Path, arguments: tuple[str, ...], words: str) -> None:
    found = run("latency", robot, *arguments)
    assert found.exit_code == 2 and words in found.output and "Traceback" not in found.output


def test_a_model_without_times_is_refused(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "empty.net"
    path.write_text("tr t p -> q\n")
    found = run("latency", path)
    assert found.exit_code == 2 and "defined for system models only" in found.output
