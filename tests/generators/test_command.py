"""``dineros generate`` as its users meet it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from lxml import etree

from dineros.cli.main import main
from dineros.generators import read_manifest
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.generators.models import add_transition, kitchen, remove_transition
from tests.support.programs.commands import is_one_line_of_wrong_use

Run = Callable[..., Result]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run `dineros generate` on the model of this test; results have `exit_code`, `stdout` and `stderr`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DINEROS_DEBUG", raising=False)
    save(kitchen(), "kitchen.sym.xmi")

    def invoke(*arguments: object) -> Result:
        options = ["generate", "kitchen.sym.xmi", "-o", "ws", *map(str, arguments)]
        return CliRunner().invoke(main, options)

    return invoke


def test_a_workspace_from_nothing_and_again(run: Run) -> None:
    assert run("--check").exit_code == 1
    first = run()
    assert (first.exit_code, first.stdout) == (0, "ws: 72 new files, 0 changed\n")
    assert (run().stdout, run("--check").stdout) == ("ws: up to date\n", "ws: up to date\n")
    assert run("--check").exit_code == 0


def test_a_change_is_named_before_and_after(run: Run, tmp_path: Path) -> None:
    run()
    model = kitchen()
    add_transition(model)
    remove_transition(model, "TShow")
    save(model, "kitchen.sym.xmi")
    check = run("--check")
    assert check.exit_code == 1
    assert "ws/src/waiter/waiter/handlers.py: is stale: stub for TPay\n" in check.stdout
    assert re.search(
        r"ws/src/board/board/handlers.py:\d+: handles TShow, which is no longer a transition of board",
        check.stdout,
    )
    assert check.stdout.splitlines()[-1] == "ws: 10 stale files, 1 handwritten part to revise"
    done = run()
    assert done.exit_code == 0
    assert "ws/src/waiter/waiter/handlers.py: extended: stub for TPay\n" in done.stdout
    assert done.stdout.splitlines()[-1] == "ws: 0 new files, 10 changed"
    again = run("--check")
    assert (again.exit_code, again.stdout.count("\n")) == (1, 2)


def test_json(run: Run) -> None:
    made = json.loads(run("--json").stdout)
    assert made["written"] is True
    assert {"file": "src/waiter/setup.py", "what": "new", "detail": ""} in made["changes"]
    model = kitchen()
    remove_transition(model, "TServe")
    save(model, "kitchen.sym.xmi")
    result = run("--check", "--json")
    found = json.loads(result.stdout)
    assert (result.exit_code, found["stale"], found["written"]) == (1, True, False)
    (notice,) = found["notices"]
    assert (notice["rule"], notice["path"]) == ("obsolete-handler", "src/waiter/waiter/handlers.py")


def test_an_edit_is_refused_with_its_difference(run: Run) -> None:
    run()
    path = Path("ws/src/waiter/setup.py")
    path.write_text(path.read_text().replace("zip_safe=True", "zip_safe=False"))
    result = run()
    assert (result.exit_code, result.stdout) == (2, "")
    assert "src/waiter/setup.py was edited:\n--- src/waiter/setup.py (generated)\n" in result.stderr
    assert "\n-    zip_safe=True,\n+    zip_safe=False,\n" in result.stderr
    assert result.stderr.splitlines()[-1].startswith(
        "ws/src/waiter/setup.py: was edited: nothing is written ("
    )
    check = run("--check")
    assert (check.exit_code, check.stdout) == (
        1,
        "ws/src/waiter/setup.py: was edited\nws: 1 stale file, 0 handwritten parts to revise\n",
    )


def test_options_are_remembered(run: Run) -> None:
    run("--lifecycle", "--maintainer", "Ada <ada@example.org>", "--license", "MIT")
    assert run("--check").exit_code == 0
    launch = Path("ws/src/kitchen_bringup/launch/kitchen.launch.py").read_text()
    assert "LifecycleNode(" in launch
    assert (
        '<maintainer email="ada@example.org">Ada</maintainer>'
        in Path("ws/src/waiter/package.xml").read_text()
    )
    assert run("--plain", "--check").exit_code == 1
    run("--plain")
    assert "LifecycleNode" not in Path("ws/src/kitchen_bringup/launch/kitchen.launch.py").read_text()
    manifest = read_manifest(Path("ws"))
    assert manifest is not None
    assert manifest.options["lifecycle"] is False
    assert manifest.options["license"] == "MIT"


def test_settings_change_the_model_and_are_named(run: Run) -> None:
    run("--set", "Hungry.tokens=7")
    text = Path("ws/src/waiter/waiter/node.rtm.xmi").read_text()
    assert 'id="Hungry" tokens="7"' in text
    settings = 'SETTINGS: list[str] = ["Hungry.tokens=7", "middleware=ros2"]'
    assert settings in Path("ws/src/waiter/waiter/base.py").read_text()
    manifest = read_manifest(Path("ws"))
    assert manifest is not None
    assert manifest.settings == ("Hungry.tokens=7", "middleware=ros2")
    assert run("--check").exit_code == 1


def test_a_template_of_ones_own(run: Run) -> None:
    own = Path("mine/node")
    own.mkdir(parents=True)
    (own / "README.md.j2").write_text(
        "{{ header('<!--', '-->') }}\n# My {{ node.package }} for {{ app.name | md }}\n"
    )
    run("--templates", "mine")
    text = Path("ws/src/waiter/README.md").read_text()
    assert text.endswith("\n# My waiter for kitchen\n")
    assert "with your own node/README.md.j2; edits are refused." in text
    assert "Generated by" in Path("ws/src/kitchen_bringup/README.md").read_text()
    assert run("--check", "--templates", "mine").exit_code == 0
    (own / "README.md.j2").write_text("Changed.\n")
    assert run("--check", "--templates", "mine").stdout.count("README.md: is stale\n") == 3
    run("--templates", "mine")
    assert Path("ws/src/waiter/README.md").read_text() == "Changed.\n"


def test_templates_of_a_workspace_must_be_named_each_time(run: Run) -> None:
    Path("mine/node").mkdir(parents=True)
    Path("mine/node/README.md.j2").write_text("Mine.\n")
    run("--templates", "mine")
    for option in ([], ["--check"]):
        said = "ws: was generated with the templates of '../mine', which must be given again (use --templates"
        assert is_one_line_of_wrong_use(run(*option), said)
    assert Path("ws/src/waiter/README.md").read_text() == "Mine.\n"
    assert run("--default-templates").exit_code == 0
    assert run("--check").exit_code == 0
    assert Path("ws/src/waiter/README.md").read_text() != "Mine.\n"


def test_a_template_is_no_program(run: Run) -> None:
    Path("mine/node").mkdir(parents=True)
    Path("mine/node/README.md.j2").write_text("{{ cycler.__init__.__globals__.os.system('touch MARK') }}\n")
    said = "mine/node/README.md.j2:1: access to attribute '__init__' of 'type' object is unsafe."
    assert is_one_line_of_wrong_use(run("--templates", "mine"), said)
    assert not Path("MARK").exists()


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("node/README.md.j2", "a\n{% if %}\n", "mine/node/README.md.j2:2: "),
        ("node/README.md.j2", "a\nb\n{{ node.nonsense }}\n", "mine/node/README.md.j2:3: "),
        ("node/README.md.j2", "{{ nonsense }}\n", "mine/node/README.md.j2:1: 'nonsense' is undefined"),
        (
            "node/README.md.j2",
            "a\n{{ app.name }}\n",
            "mine/node/README.md.j2:2: 'kitchen' is written without a filter (write ",
        ),
        ("node/README.md.j2", "{{ app.name | safe }}", "is written without a filter"),
        ("node/README.md.j2", "{{ node.package ~ app.name }}", "'waiterkitchen' is written without a filter"),
        ("node/README.md.j2", "{{ app.id | name ~ '' }}", "'kitchen' is written without a filter"),
        (
            "node/__init__.py.j2",
            "a b {{ node.package }}\n",
            "does not produce valid Python: invalid syntax: 'a b waiter'",
        ),
        ("node/REDAME.md.j2", "", "mine/node/REDAME.md.j2: overrides no template (did you mean 'node/README"),
    ],
)
def test_a_bad_template_is_refused(run: Run, name: str, text: str, said: str) -> None:
    path = Path("mine") / name
    path.parent.mkdir(parents=True)
    path.write_text(text)
    assert is_one_line_of_wrong_use(run("--templates", "mine"), said)
    assert not Path("ws").exists()


def test_templates_that_are_not_there_are_refused(run: Run) -> None:
    assert is_one_line_of_wrong_use(run("--templates", "nowhere"), "nowhere: is not a folder with templates")


def test_an_invalid_model_is_refused(run: Run) -> None:
    model = kitchen()
    find(model, "ServedMeals", sym.TopicChannel).publishers[0].limit = 0
    save(model, "kitchen.sym.xmi")
    assert is_one_line_of_wrong_use(run(), "is not valid: ")
    assert not Path("ws").exists()


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("waiter.package=kitchen_cook", "the package 'kitchen_cook' of node net 'cook' is that of 'waiter'"),
        ("waiter.package=kitchen_bringup", "is that of the launch files (set the package of the node net"),
        ("waiter.package=queue", "the package 'queue' of node net 'waiter' is that of Python"),
    ],
)
def test_packages_that_collide_are_refused(run: Run, setting: str, said: str) -> None:
    model = kitchen()
    find(model, "waiter", sym.NodeNet).package = setting.partition("=")[2]
    save(model, "kitchen.sym.xmi")
    assert is_one_line_of_wrong_use(run(), said)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("isHot", "messageId", "becomes the message field 'message_id', which carries the id of the message"),
        ("isHot", "Guest", "becomes the message field 'guest', as does 'Guest'"),
        ("isHot", "default", "becomes the message field 'default', a keyword of C++ or Python"),
    ],
)
def test_fields_that_ros_cannot_have_are_refused(run: Run, old: str, new: str, said: str) -> None:
    model = kitchen()
    assert model.tokenType is not None
    next(field for field in model.tokenType.fields if field.name == old).name = new
    save(model, "kitchen.sym.xmi")
    assert is_one_line_of_wrong_use(run(), said)


@pytest.mark.parametrize("name", ["a---b", "a\nimport evil\n", "\udcff"])
def test_any_name_of_a_file_is_text(run: Run, name: str) -> None:
    """XML can be read, the manifest says the name, and the next generation finds all up to date."""
    source = f"{name}.sym.xmi"
    save(kitchen(), source)
    command = ["generate", source, "-o", "other", "--set", "Hungry.name=x---y"]
    assert CliRunner().invoke(main, command).exit_code == 0
    for path in ("package.xml", "waiter/node.rtm.xmi"):
        etree.parse(Path("other/src/waiter") / path)
    manifest = read_manifest(Path("other"))
    assert manifest is not None
    assert manifest.source == source.encode(errors="replace").decode()  # half a character is none
    assert "up to date" in CliRunner().invoke(main, command).stdout
