"""`dineros import` and `dineros diff` on a recording: files, formats, statuses, and errors of one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from dineros.observation.importing.given_reading import given_beside, read_given
from tests.cli.conftest import Run
from tests.support.programs.bags import write_bag


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    return write_bag(tmp_path / "monday", [("/scan", 0), ("/pose", 1)])


@pytest.fixture
def seen(bag: Path, tmp_path: Path, run: Run) -> Path:
    model = tmp_path / "seen.sym.xmi"
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    return model


def test_an_import_writes_the_model_and_once_what_is_to_be_given(seen: Path, bag: Path, run: Run) -> None:
    given = given_beside(seen)
    assert read_given(given).topics == {}
    given.write_text('[topic."/scan"]\npublishers = ["/lidar"]\n')
    result = run("import", "--bag", bag, "-o", seen)
    assert result.exit_code == 0
    assert given.read_text().startswith("[topic")
    assert 'id="lidar"' in seen.read_text()
    assert run("validate", seen).exit_code == 0


def test_a_topic_without_a_slash_is_a_topic_of_the_model(tmp_path: Path, run: Run) -> None:
    bag = write_bag(tmp_path / "bag", [("scan", 0), ("/good", 1), ("scan", 2)])
    model = tmp_path / "a.sym.xmi"
    result = run("import", "--bag", bag, "-o", model)
    assert (result.exit_code, "2 topics, 0 found" in result.stdout) == (0, True)
    assert 'topic="scan"' in model.read_text()
    assert "conforms; 3 messages explained" in run("conform", model, "--bag", bag).stdout
    assert "0 found, 2 proved" in run("diff", model, "--bag", bag).stdout
    assert run("narrow", model, "--bag", bag).exit_code == 0
    given_beside(model).write_text('[topic.scan]\npublishers = ["/lidar"]\nsubscribers = ["/mapper"]\n')
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    assert "0 found, 2 proved" in run("diff", model, "--bag", bag).stdout
    assert "conforms; 3 messages explained" in run("conform", model, "--bag", bag).stdout


def test_a_topic_that_cannot_be_read_is_named_and_left_out(tmp_path: Path, run: Run) -> None:
    bag = write_bag(tmp_path / "bag", [("/a\x1b[2J", 0), ("/good", 1)])
    model = tmp_path / "a.sym.xmi"
    for words in (["import", "-o", model], ["diff", model], ["conform", model], ["narrow", model]):
        result = run(*words, "--bag", bag)
        assert result.exit_code == 0, result.output
        assert (
            f"{bag}: left out: topic '/a\\x1b[2J' has a name that is not a valid topic name\n"
            in result.stderr
        )
        assert "\x1b" not in result.output


def test_the_file_of_what_is_assumed_says_just_that(bag: Path, tmp_path: Path, run: Run) -> None:
    """With every # taken away, the next import assumes nothing more."""
    model = tmp_path / "a.sym.xmi"
    given = given_beside(model)
    given.write_text('[topic."/scan"]\npublishers = ["/lidar"]\nsubscribers = ["/mapper"]\n')
    first = json.loads(run("import", "--bag", bag, "-o", model, "--json").stdout)
    assert first["assumed"]
    said = given.read_text()
    given.unlink()
    again = tmp_path / "b.given.toml"
    again.write_text(said)
    run("import", "--bag", bag, "-o", model, "--given", again)
    lines = [f'[node."{each["node"]}"]\n{each["key"]} = {each["value"]}' for each in first["assumed"]]
    nodes: dict[str, dict[str, None]] = {}
    for each, line in zip(first["assumed"], lines, strict=True):
        nodes.setdefault(each["node"], {})[line.partition("\n")[2]] = None
    text = said + "".join(f'[node."{node}"]\n' + "\n".join(found) + "\n" for node, found in nodes.items())
    again.write_text(text)
    second = json.loads(run("import", "--bag", bag, "-o", model, "--given", again, "--json").stdout)
    assert second["assumed"] == []


@pytest.mark.parametrize("format", ["text", "json", "sarif", "junit"])
def test_differences_in_every_format(format: str, seen: Path, bag: Path, run: Run) -> None:
    same = run("diff", seen, "--bag", bag, "--format", format)
    other = run("diff", seen, "--bag", bag, "--format", format, "--set", "topic.scan.topic=/scans")
    assert (same.exit_code, other.exit_code) == (0, 1)
    if format == "json":
        rules = [each["rule"] for each in json.loads(other.stdout)["findings"]]
        assert rules == ["topic-extra", "topic-not-recorded"]
    elif format == "sarif":
        (found,) = json.loads(other.stdout)["runs"]
        extra = found["tool"]["driver"]["rules"][0]
        assert extra["shortDescription"]["text"] == "A topic was recorded that the model does not have."
    elif format == "junit":
        root = etree.fromstring(other.stdout.encode())
        assert (root.get("name"), root.get("failures")) == ("dineros diff", "1")
    else:
        assert "error: the model has no topic /scan" in other.stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[", "is not TOML"),
        ("a = 1", "a: is unknown"),
        ('[node."/a"]\nthreds = 2', "did you mean 'threads'?"),
        ('[node."/a"]\nthreads = 0', "is not a whole number from 1"),
        ('[node."/a"]\nthreads = true', "is not a whole number from 1"),
        ('[node."/a"]\ntimers.tick = -1', "is not a time in seconds above 0"),
        ('[node."/a"]\ngroups.g = "shared"', "is not one of exclusive, reentrant"),
        ('[node."/a"]\nlifecycle = ["dies"]', "'dies' is not one of"),
        ('[node."/a"]\ncallback."/x".does = ["shout /x"]', "'shout /x' is not a step"),
        ('[node."/a"]\ncallback."/x".does = "publish /x"', "is not a list of strings"),
        ('[node."/a"]\ncallback."/x".group = "g"', "is not a callback group of its node"),
        ('[node."/a"]\ncallback."/x".awaits = 1', "is neither true nor false"),
        ("node = 3", "node: is not a table"),
    ],
)
def test_what_is_given_wrongly_is_one_line(
    text: str, message: str, bag: Path, tmp_path: Path, run: Run
) -> None:
    given, model = tmp_path / "wrong.toml", tmp_path / "m.sym.xmi"
    given.write_text(text)
    result = run("import", "--bag", bag, "-o", model, "--given", given)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert str(given) in result.stderr
    assert message in result.stderr
    assert not model.exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ("import", "-o", "m.sym.xmi"),
        ("import", "--graph", "--bag", "monday", "-o", "m.sym.xmi"),
        ("import", "--bag", "monday", "--domain", "3", "-o", "m.sym.xmi"),
        ("import", "--bag", "monday", "-o", "m.svg"),
        ("import", "--bag", "nowhere", "-o", "m.sym.xmi"),
        ("import", "--interfaces", "moon_msgs", "-o", "m.sym.xmi"),
        ("import", "--interfaces", "../etc", "-o", "m.sym.xmi"),
        ("import", "--interfaces", "std_msgs", "--graph", "-o", "m.sym.xmi"),
        ("import", "--graph", "--domain", "3000", "-o", "m.sym.xmi"),
        ("diff", "m.sym.xmi"),
    ],
)
def test_wrong_use_is_one_line_and_no_file(
    arguments: tuple[str, ...], bag: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(bag.parent)
    before = sorted(bag.parent.iterdir())
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert sorted(bag.parent.iterdir()) == before


def test_messages_of_a_package_are_token_types(tmp_path: Path, run: Run) -> None:
    model = tmp_path / "messages.sym.xmi"
    result = run("import", "--interfaces", "std_msgs", "-o", model, "--json")
    assert result.exit_code == 0
    assert "std_msgs/msg/String" in json.loads(result.stdout)["types"]
    assert run("validate", model).exit_code == 0
