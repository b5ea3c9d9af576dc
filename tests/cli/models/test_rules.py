"""``dineros rules``, and rules that users write."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from dineros.transformations.rules.catalogue import FAMILIES, name_of
from tests.cli.conftest import Run
from tests.support.programs.system_packages import needs

WATCHDOG = Path(__file__).resolve().parents[3] / "examples/watchdog_rules.py"


def test_the_list_holds_every_rule_by_family(run: Run) -> None:
    result = run("rules")
    assert result.exit_code == 0
    for family in FAMILIES:
        assert family.title in result.stdout.splitlines()
        for rule in family.rules:
            assert f"\n  {name_of(rule)} " in result.stdout


def test_the_list_describes_each_rule_alone(run: Run) -> None:
    first = re.compile(r"(So|It|Its|They|Nor|And|Otherwise|One that|Such|None of|Also) ")
    rows = json.loads(run("rules", "--json").stdout)["rules"]
    assert [row["name"] for row in rows if first.match(row["says"])] == []


def test_the_list_as_json(run: Run) -> None:
    rows = json.loads(run("rules", "--json").stdout)["rules"]
    assert rows[1] == {
        "family": "topics",
        "name": "T2",
        "says": "Overflowing send queue of each publisher port",
    }
    assert len(rows) == sum(len(family.rules) for family in FAMILIES)


def test_one_rule_as_text_and_json(run: Run) -> None:
    result = run("rules", "i5-io-enabled")
    assert result.exit_code == 0
    assert result.stdout.startswith("I5-io-enabled: A signal also changes by a second pair")
    assert "  change.to_true   Transition {signal.id}.toTrueOut.{transition.id}\n" in result.stdout
    described = json.loads(run("rules", "T1", "--json").stdout)
    assert described["lhs"] == [{"name": "channel", "is": "TopicChannel"}]
    assert described["rhs"][-1] == {"name": "arc", "is": "topic -> transport"}


@needs("graphviz")
def test_a_rule_is_drawn(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "t2.svg"
    result = run("rules", "T2", "-o", out)
    assert (result.exit_code, result.stdout) == (0, f"T2 -> {out}\n")
    assert "</svg>" in out.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["T55"], "there is no rule 'T55' (did you mean 'T5b' or 'T5a'?)"),
        (["-o", "t2.svg"], "name the rule to draw"),
        (["T1", "-o", "t1.jpg"], "t1.jpg: '.jpg' is not a format of pictures (known are .svg, .png, .dot)"),
        (["T1", "-o", "missing/t1.dot"], "create the folder first"),
        (["--rules", "missing.py"], "missing.py: cannot be read: No such file or directory"),
    ],
)
def test_wrong_use_is_one_line(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], part: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("rules", *arguments)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert part in result.stderr
    assert not list(tmp_path.iterdir())


def test_a_users_rules_are_listed_and_described(run: Run) -> None:
    assert f"Rules of {WATCHDOG}\n  Watchdog" in run("rules", "--rules", WATCHDOG).stdout
    assert "waiting <-> t_timeout" in run("rules", "Watchdog", "--rules", WATCHDOG).stdout


HEAD = """from dineros.metamodel import pn, sym
from dineros.transformations.rules.notation import place
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.topics import T1

"""


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        ("node = Node(sym.PublisherPort, chanel=1)", 7, "has no feature 'chanel' (did you mean 'channel'?)"),
        ("node = Made(T1.topik)", 7, "T1 has no 'topik' (did you mean 'topic'?)"),
        (
            "class R(Rule):\n    a = place('{b}')\n    rhs = [a]",
            8,
            "placeholder {b} is not an element of the rule",
        ),
        ("x = (", 7, "is not Python"),
        ("\n\nprint(1 / 0)", 9, "ZeroDivisionError: division by zero"),
        ("import no_such_module_anywhere", 7, "ModuleNotFoundError"),
        ("", None, "has no list RULES (end it with RULES = [MyRule])"),
        ("RULES = Rule", None, "has no list RULES"),
        ("RULES = [pn.Place]", None, "which is not a rule"),
    ],
)
def test_a_fault_in_a_users_file_is_one_line_with_its_place(
    run: Run, tmp_path: Path, text: str, line: int | None, part: str
) -> None:
    path = tmp_path / "my_rules.py"
    path.write_text(HEAD + text + "\n", encoding="utf-8")
    result = run("rules", "--rules", path)
    place = f"{path}:{line}: " if line else f"{path}: "
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert result.stderr.startswith(place)
    assert part in result.stderr


def test_a_users_file_may_import_its_neighbours(run: Run, tmp_path: Path) -> None:
    (tmp_path / "helper_of_these_rules.py").write_text(
        "from dineros.transformations.rules.topics import T1\n"
    )
    path = tmp_path / "my_rules.py"
    path.write_text("from helper_of_these_rules import T1\nRULES = [T1]\n", encoding="utf-8")
    assert run("rules", "--rules", path).exit_code == 0
