"""`dineros narrow`: proposals accepted one by one and by a threshold, files, statuses, errors of one line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from dineros.metamodel.records import write_records
from dineros.observation.importing.given_reading import given_beside, read_given
from tests.cli.conftest import Run
from tests.observation.measuring.camera import KnownRun, camera
from tests.support.programs.bags import service_event, write_bag
from tests.support.traces import Trace

GIVEN = """
[topic."/scan"]
publishers = ["/lidar"]
subscribers = ["/mapper"]
[topic."/map"]
publishers = ["/mapper"]
[service."/where"]
servers = ["/mapper"]
clients = ["/driver"]
"""
MILLISECOND = 1_000_000


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A recording: a map follows each second scan or so, and a driver asks now and then."""
    messages: list[tuple[str, int] | tuple[str, int, bytes]] = []
    for number in range(20):
        time = number * 100 * MILLISECOND
        messages.append(("/scan", time))
        if number in (1, 2, 5, 6, 7, 11, 12, 15, 18, 19):
            messages.append(("/map", time + MILLISECOND))
        if number % 4 == 1:
            messages += [
                (
                    "/where/_service_event",
                    time + (20 + 3 * kind + number) * MILLISECOND,
                    service_event(kind, number),
                )
                for kind in range(4)
            ]
    types = {"/where/_service_event": "std_srvs/srv/Trigger_Event"}
    return write_bag(tmp_path / "monday", messages, types=types)


@pytest.mark.parametrize("is_changed", [False, True])
def test_only_a_changed_model_is_called_changed(
    bag: Path, tmp_path: Path, run: Run, is_changed: bool
) -> None:
    model = tmp_path / "seen.sym.xmi"
    given_beside(model).write_text(GIVEN.replace('publishers = ["/mapper"]', ""))  # one is invented
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    if is_changed:
        place = '<objects xsi:type="sym:Place" id="mapper.extra"/>'
        model.write_text(
            re.sub(r'(<pages [^>]*id="mapper"[^>]*>)', rf"\1{place}", model.read_text(), count=1)
        )
        assert place in model.read_text()
    found = run("narrow", model, "--bag", bag)
    assert ("was changed after its import" in found.stderr) == is_changed


@pytest.fixture
def seen(bag: Path, tmp_path: Path, run: Run) -> Path:
    model = tmp_path / "seen.sym.xmi"
    given_beside(model).write_text(GIVEN)
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    return model


def test_proposals_are_numbered_and_nothing_is_written(seen: Path, bag: Path, run: Run) -> None:
    before = sorted(seen.parent.iterdir())
    result = run("narrow", seen, "--bag", bag)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert [line.split()[0] for line in lines[:-2]] == [str(number) for number in range(1, len(lines) - 1)]
    assert any(
        "/mapper: /scan sometimes leads to /map (10 of 20 followed, within 1 ms to 1 ms; 10 of 10" in line
        for line in lines
    )
    assert any("/driver: a timer of 0.404 s asks /where (5 requests" in line for line in lines)
    assert lines[-2:] == [
        "/where: 5 of 5 requests answered, within 3 to 3 ms; by the server",
        "/where: 5 of 5 requests answered, within 9 to 9 ms; by clients",
    ]
    assert sorted(seen.parent.iterdir()) == before


def proposed(seen: Path, bag: Path, run: Run) -> list[dict[str, object]]:
    found = json.loads(run("narrow", seen, "--bag", bag, "--json").stdout)
    assert found["narrowed"] is None
    assert found["services"]["/where"]["answers"]["response sent"] == {
        "count": 5,
        "least": 0.003,
        "most": 0.003,
    }
    proposals: list[dict[str, object]] = found["proposals"]
    return proposals


def test_one_by_one(seen: Path, bag: Path, run: Run) -> None:
    """What is accepted holds, the rest stays open; and the narrowed model replays the recording."""
    output = seen.with_name("one.sym.xmi")
    found = proposed(seen, bag, run)
    kinds = [(each["callback"], each["kind"]) for each in found]
    number = 1 + kinds.index(("/scan", "sometimes"))
    result = run("narrow", seen, "--bag", bag, "--accept", number, "-o", output)
    assert (result.exit_code, result.stdout) == (
        0,
        f"{output}: 1 proposal accepted; explains 50 messages of {bag}\n",
    )
    said = read_given(given_beside(output))
    assert [str(step) for step in said.nodes["/mapper"].callbacks["/scan"].does or ()] == ["publish /map ?"]
    assert said.nodes["/mapper"].callbacks["/where"].does == ()
    assert "/lidar" not in said.nodes
    assert str(found[number - 1]["followed"]) in given_beside(output).read_text()
    assert run("conform", output, "--bag", bag).exit_code == 0
    assert run("diff", output, "--bag", bag).exit_code == 0


def test_by_a_threshold(seen: Path, bag: Path, run: Run) -> None:
    """The next import of the same recording, with what is given then, is the same model."""
    output = seen.with_name("sure.sym.xmi")
    found = proposed(seen, bag, run)
    result = run("narrow", seen, "--bag", bag, "--threshold", "0.85", "-o", output, "--json")
    assert result.exit_code == 0
    narrowed = json.loads(result.stdout)["narrowed"]
    assert narrowed["status"] == "conforms" and narrowed["messages"] == 50
    sure = [each for each in found if float(str(each["confidence"])) >= 0.85]
    assert 0 < len(sure) < len(found)
    assert narrowed["accepted"] == sure and narrowed["dropped"] == []
    again = seen.with_name("again.sym.xmi")
    run("import", "--bag", bag, "-o", again, "--given", given_beside(output))
    assert run("conform", again, "--bag", bag).exit_code == 0
    invented = write_bag(bag.with_name("odd"), [("/scan", 0), ("/map", 5), ("/map", 400 * MILLISECOND)])
    assert run("conform", seen, "--bag", invented).exit_code == 0
    assert run("conform", again, "--bag", invented).exit_code == 1


def test_a_response_that_no_client_took_is_a_finding(seen: Path, tmp_path: Path, run: Run) -> None:
    events = [(0, 0), (1, 1), (2, 2)]
    topic = "/where/_service_event"
    bag = write_bag(
        tmp_path / "stuck",
        [
            *((topic, time * MILLISECOND, service_event(kind, 1)) for kind, time in events),
            *(("/scan", 1000 * n * MILLISECOND) for n in range(20)),
        ],
        types={topic: "std_srvs/srv/Trigger_Event"},
    )
    said = "/where: answered, never taken: 1 response, the first one 19 s before the end"
    result = run("narrow", seen, "--bag", bag)
    assert (result.exit_code, said in result.stdout.splitlines()) == (1, True)
    result = run("narrow", seen, "--bag", bag, "--threshold", 1, "-o", tmp_path / "narrowed.sym.xmi")
    assert (result.exit_code, said in result.stdout.splitlines()) == (1, True)
    result = run("narrow", seen, "--bag", bag, "--json")
    untaken = [{"service": "/where", "responses": 1, "seconds": 18.998}]
    assert (result.exit_code, json.loads(result.stdout)["untaken"]) == (1, untaken)
    result = run("conform", seen, "--bag", bag)
    assert (result.exit_code, f"{seen}: {said}" in result.stdout.splitlines()) == (1, True)
    result = run("conform", seen, "--bag", bag, "--json")
    assert (result.exit_code, json.loads(result.stdout)["untaken"]) == (1, untaken)


def test_nothing_to_propose(seen: Path, tmp_path: Path, run: Run) -> None:
    few = write_bag(tmp_path / "few", [("/scan", 0), ("/map", 1)])
    result = run("narrow", seen, "--bag", few)
    assert (result.exit_code, result.stdout) == (0, f"{few}: no proposals\n")
    assert json.loads(run("narrow", seen, "--bag", few, "--json").stdout)["proposals"] == []
    output = tmp_path / "same.sym.xmi"
    assert run("narrow", seen, "--bag", few, "--threshold", "0", "-o", output).exit_code == 0
    refused = run("narrow", seen, "--bag", few, "--accept", 1, "-o", tmp_path / "none.sym.xmi")
    assert refused.exit_code == 2 and "there is no proposal 1 (there is none)" in refused.stderr


def test_bad_recordings_are_one_line_and_nothing_is_half_written(
    seen: Path, bag: Path, tmp_path: Path, run: Run
) -> None:
    (tmp_path / "cut.mcap").write_bytes((bag / "monday.mcap").read_bytes()[:500])
    (tmp_path / "nothing.mcap").touch()
    types = {"/scan": "std_msgs/msg/String", "/where/_service_event": "std_srvs/srv/Trigger_Event"}
    bad = {
        "cut.mcap": "is damaged or cut off",
        "nothing.mcap": "is empty",
        write_bag(tmp_path / "silent", [], types=types).name: "holds no message",
        write_bag(tmp_path / "odd", [("/where/_service_event", 1)], types=types).name: "is not an event",
        write_bag(tmp_path / "other", [("/elsewhere", 1)]).name: "no topic of the model was recorded",
        "missing": "this recording does not exist",
    }
    before = sorted(tmp_path.iterdir())
    for name, message in bad.items():
        output = tmp_path / "out.sym.xmi"
        result = run("narrow", seen, "--bag", tmp_path / name, "--threshold", "0.5", "-o", output)
        assert result.exit_code == 2, name
        assert message in result.stderr and result.stderr.count("\n") == 1
        assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--threshold", "0.9"], "--threshold and --accept require -o"),
        (["-o", "new.sym.xmi"], "--threshold and --accept require -o"),
        (["--accept", "99", "-o", "new.sym.xmi"], "there is no proposal 99"),
        (["--threshold", "2", "-o", "new.sym.xmi"], "2"),
        (["--accept", "1", "-o", "new.svg"], ".xmi"),
        (["--accept", "1", "-o", "seen.sym.xmi"], "already exists and may contain manual edits"),
        (["--within", "0"], "0"),
    ],
)
def test_wrong_use_is_one_line_and_no_file(
    arguments: list[str], message: str, seen: Path, bag: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(seen.parent)
    before = {path: path.read_bytes() for path in seen.parent.iterdir() if path.is_file()}
    result = run("narrow", seen, "--bag", bag, *arguments)
    assert result.exit_code == 2
    assert message in result.stderr and result.stderr.count("\n") == 1
    assert {path: path.read_bytes() for path in seen.parent.iterdir() if path.is_file()} == before


def traced() -> Trace:
    trace = Trace()
    mapper = trace.node("/mapper")
    scanned, grid = trace.subscription(mapper, "/scan"), trace.publisher(mapper, "/map")
    for _ in range(5):
        trace.run(scanned, [grid])
    return trace


def test_the_examples_of_help_run(seen: Path, bag: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(seen.parent)
    bag.rename("recording")
    traced().write(Path("trace"))
    save(camera(), Path("watch.sym.xmi"))
    for node, records in KnownRun(1, quick=True).records.items():
        Path("watched").mkdir(exist_ok=True)
        write_records(Path("watched", f"{node}.jsonl"), records)
    text = run("narrow", "--help").stdout
    examples = [line.strip() for line in text.splitlines() if line.strip().startswith("dineros narrow ")]
    assert len(examples) == 5
    for example in examples:
        _, *words = example.split()
        result = run(*words)
        assert result.exit_code == 0, result.output
        for written in seen.parent.glob("narrowed.*"):
            written.unlink()
