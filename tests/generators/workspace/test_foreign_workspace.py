"""A workspace from somebody else: `generate` does nothing outside of it, and runs nothing of it."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dineros.generators import Options, check, generate
from dineros.generators.workspace.building import build_interfaces
from dineros.generators.workspace.manifest import PLACE
from dineros.metamodel.errors import DinerosError
from tests.generators.models import kitchen, rename_node

OPTIONS = Options(source="kitchen.sym.xmi")
HANDLERS = "src/waiter/waiter/handlers.py"


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Return a workspace beside a file of its user's."""
    generate(kitchen(), tmp_path / "ws", OPTIONS)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file.json").write_text('{"about":"a","steps":[],"marking":{}}')
    return tmp_path / "ws"


def change(workspace: Path, **values: Any) -> None:
    """Change values of the manifest; a dict is put before the one that is there."""
    path = workspace / PLACE
    manifest = json.loads(path.read_text())
    for name, value in values.items():
        manifest[name] = value | manifest[name] if isinstance(value, dict) else value
    path.write_text(json.dumps(manifest))


def refused(workspace: Path, said: str) -> None:
    """Require that both ways to use a workspace refuse it, in one line that names its file."""
    for work in (check, generate):
        with pytest.raises(DinerosError) as caught:
            work(kitchen(), workspace, OPTIONS)
        assert said in str(caught.value)
        assert str(caught.value).startswith(str(workspace))
        assert "\n" not in str(caught.value)


@pytest.mark.long
@pytest.mark.parametrize(
    "path",
    [
        "../mine/file.json",
        "{outside}/mine/file.json",
        "src/kitchen_bringup/test/steps/../../../../../mine/file.json",
        "src/../../mine/file.json",
        ".git/config",
    ],
)
@pytest.mark.parametrize("field", ["generated", "pending", "developer"])
def test_paths_of_the_manifest_stay_inside(workspace: Path, field: str, path: str) -> None:
    victim = workspace.parent / "mine" / "file.json"
    before = victim.read_bytes()
    digest = hashlib.sha256(before).hexdigest()
    (workspace / PLACE).write_text(
        (workspace / PLACE).read_text().replace('"developer"', '"pending":{},"developer"')
    )
    entry = {"node": "cook", "written": digest, "stubs": {}} if field == "developer" else digest
    change(workspace, **{field: {path.format(outside=workspace.parent): entry}})
    refused(workspace, "is outside of the workspace or a hidden file")
    assert victim.read_bytes() == before


def test_templates_of_the_manifest_are_not_rendered(workspace: Path) -> None:
    (workspace / "tpl/node").mkdir(parents=True)
    (workspace / "tpl/node/marker.j2").write_text("stolen")
    manifest = (workspace / PLACE).read_text()
    (workspace / PLACE).write_text(manifest.replace('"templates": null', '"templates": "tpl"'))
    refused(workspace, "was generated with the templates of 'tpl', which must be given again")


@pytest.mark.long
@pytest.mark.parametrize("place", ["src", "src/waiter", "src/waiter/waiter", HANDLERS, "src/waiter/setup.py"])
def test_links_are_refused(workspace: Path, place: str) -> None:
    path = workspace / place
    path.rename(workspace.parent / "moved")
    path.symlink_to(workspace.parent / "moved")
    before = sorted(workspace.parent.rglob("*"))
    refused(workspace, f"{place}: is a symbolic link, which is not followed here")
    renamed = kitchen()
    rename_node(renamed, "waiter", "server")
    with pytest.raises(DinerosError, match="is a symbolic link"):
        generate(renamed, workspace, OPTIONS)
    assert sorted(workspace.parent.rglob("*")) == before


def test_a_dangling_link_makes_no_file(tmp_path: Path) -> None:
    (tmp_path / "ws/src/waiter").mkdir(parents=True)
    (tmp_path / "ws/src/waiter/package.xml").symlink_to(tmp_path / "made")
    refused(tmp_path / "ws", "src/waiter/package.xml: is a symbolic link")
    assert not (tmp_path / "made").exists()


def test_links_of_the_build_are_refused(workspace: Path) -> None:
    (workspace / "install").symlink_to(workspace.parent / "mine")
    (workspace.parent / "mine" / "kitchen_interfaces").mkdir()
    with pytest.raises(DinerosError, match="install: is a symbolic link"):
        build_interfaces(workspace)
    assert (workspace.parent / "mine" / "kitchen_interfaces").is_dir()


@pytest.mark.parametrize("place", [PLACE, HANDLERS, "src/waiter/setup.py"])
def test_a_pipe_does_not_hang(workspace: Path, place: str) -> None:
    (workspace / place).unlink()
    os.mkfifo(workspace / place)
    refused(workspace, f"{place}: is not a plain file")


def changed_entry(name: str, value: object) -> Callable[[dict[str, Any]], object]:
    def work(manifest: dict[str, Any]) -> None:
        *parts, last = name.split(".")
        place: Any = manifest
        for part in parts:
            place = place[int(part)] if part.isdigit() else place[part]
        place[int(last) if last.isdigit() else last] = value

    return work


MALFORMED: list[tuple[Callable[[dict[str, Any]], object], str]] = [
    (changed_entry("schema", True), "has no schema"),
    (changed_entry("schema", "1"), "has no schema"),
    (changed_entry("schema", 2), "has the schema 2; the newest supported one is 1"),
    (changed_entry("settngs", []), "unknown field settngs (did you mean 'settings'?)"),
    (lambda manifest: manifest.pop("nodes"), "has no field nodes"),
    (changed_entry("model", 1), "model is not text"),
    (changed_entry("source", "x" * 5000), "source has more than 4096 characters"),
    (changed_entry("settings", "a=1"), "settings is not a list"),
    (changed_entry("settings", [1]), "settings[0] is not text"),
    (changed_entry("options", None), "options is not an object"),
    (changed_entry("options.lifecycle", 1), "options.lifecycle is neither true nor false"),
    (changed_entry("options.templates", ["x"]), "options.templates is not text"),
    (changed_entry("options.other", 1), "unknown field options.other"),
    (changed_entry("interfaces", "../x"), "interfaces is not a name of a package: '../x'"),
    (changed_entry("bringup", ""), "bringup is not a name of a package: ''"),
    (changed_entry("token", {"a": []}), "token.a is not text"),
    (changed_entry("nodes.0.package", "/tmp"), "nodes[0].package is not a name of a package"),
    (changed_entry("nodes.0.name", "a b"), "nodes[0].name is not a name in ROS"),
    (changed_entry("nodes.0", 7), "nodes[0] is not an object"),
    (changed_entry("generated", {"src/a": "0"}), "generated.src/a is not a SHA-256"),
    (changed_entry("generated", []), "generated is not an object"),
    (changed_entry("developer", {"src/a": {}}), "has no field developer.src/a.node"),
    (
        changed_entry(
            "developer",
            {"src/a": {"node": None, "written": "", "stubs": {"T": {"inputs": [], "outputs": 1}}}},
        ),
        "developer.src/a.stubs.T.outputs is not a list",
    ),
]


@pytest.mark.long
@pytest.mark.parametrize(("work", "said"), MALFORMED, ids=[said for _, said in MALFORMED])
def test_malformed_manifests(workspace: Path, work: Callable[[dict[str, Any]], object], said: str) -> None:
    manifest = json.loads((workspace / PLACE).read_text())
    work(manifest)
    (workspace / PLACE).write_text(json.dumps(manifest))
    refused(workspace, said)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no JSON"),
        (b"[]", "has no schema"),
        (b"[" * 100_000, "nested too deep"),
        (b'{"schema":' + b"1" * 5000 + b"}", "a number of 5000 characters"),
        (b"\xff", "no UTF-8"),
        (b" " * (17 << 20), "is larger than 16 MiB"),
    ],
    ids=["empty", "list", "deep", "digits", "latin", "large"],
)
def test_manifests_that_are_none(workspace: Path, content: bytes, said: str) -> None:
    (workspace / PLACE).write_bytes(content)
    refused(workspace, said)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        (
            "a(): pass\nimport os\ndef b.json",
            '{"about":"a","steps":[],"marking":{}}',
            "is not a name of a script",
        ),
        ("a.json", '{"about":"a","steps":[],"marking":{"Hungry":"exit()"}}', "is not a script of steps"),
        ("a.json", '{"about":"a","steps":[[{}]],"marking":{}}', "is not a script of steps"),
        ("a.json", '{"about":1,"steps":[],"marking":{}}', "is not a script of steps"),
        ("a.json", "[" * 100_000, "nested too deep"),
    ],
)
def test_scripts_are_checked(workspace: Path, name: str, content: str, said: str) -> None:
    steps = workspace / "src/kitchen_bringup/test/steps"
    steps.mkdir(parents=True)
    (steps / name).write_text(content)
    digest = hashlib.sha256(content.encode()).hexdigest()
    change(workspace, generated={f"src/kitchen_bringup/test/steps/{name}": digest})
    for work in (check, generate):
        with pytest.raises(DinerosError, match=said):
            work(kitchen(), workspace, OPTIONS)


KILLING = """
import os, signal, sys
from pathlib import Path
from dineros.generators import Options, generate
from tests.generators.models import kitchen

real = os.replace
for number, writes in enumerate(range(0, 60, 5)):
    child = os.fork()
    if child == 0:
        left = writes

        def replace(*arguments, **options):
            global left
            if not left:
                os.kill(os.getpid(), signal.SIGKILL)
            left -= 1
            real(*arguments, **options)

        os.replace = replace
        workspace = Path(sys.argv[1]) / f"ws{number}"
        if number % 2:
            workspace.mkdir()
        generate(kitchen(), workspace, Options(source="kitchen.sym.xmi"))
        os._exit(0)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
"""


@pytest.mark.long
def test_killed_runs_leave_nothing_to_the_next(tmp_path: Path) -> None:
    """They are killed when a file is not yet in its place, in a new folder or in one that exists."""
    generate(kitchen(), tmp_path / "whole", OPTIONS)
    subprocess.run([sys.executable, "-c", KILLING, str(tmp_path)], check=True, timeout=300)
    whole = {path.relative_to(tmp_path / "whole") for path in (tmp_path / "whole").rglob("*")}
    for number in range(12):
        workspace = tmp_path / f"ws{number}"
        assert workspace.exists() == bool(number % 2)
        left = workspace if number % 2 else tmp_path / f".ws{number}.0.dineros-tmp"
        assert list(left.rglob("*.dineros-tmp"))
        generate(kitchen(), workspace, OPTIONS)
        assert {path.relative_to(workspace) for path in workspace.rglob("*")} == whole
    assert not list(tmp_path.rglob("*.dineros-tmp"))


def test_leftovers_go_where_their_file_is_generated_no_longer(workspace: Path) -> None:
    """The kill came before the file was there, and the model has changed since."""
    for place in ("src/waiter/waiter", ".dineros", "src/kitchen_interfaces/msg"):
        (workspace / place / ".Gone.msg.0.dineros-tmp").write_bytes(b"half")
    (workspace / "src/waiter/waiter/.mine.tmp").write_bytes(b"kept")
    model = kitchen()
    rename_node(model, "waiter", "server")
    generate(model, workspace, OPTIONS)
    assert [path.name for path in workspace.rglob("*tmp")] == [".mine.tmp"]
