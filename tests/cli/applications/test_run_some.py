"""Some nodes of a model run; the others are elsewhere."""

from __future__ import annotations

import fcntl
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.cli.running import ros
from dineros.cli.running.applications import application_of
from dineros.generators import Options, generate
from dineros.generators.workspace import building
from dineros.metamodel import sym
from dineros.metamodel.elements import places
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.programs.on_ros import on_ros
from tests.support.systems.talker import talker


@pytest.mark.parametrize("way", ["--local", "--simulate"])
@pytest.mark.parametrize(
    ("options", "places"),
    [
        (["--only", "talker"], {"Words"}),
        (["--only", "/talker"], {"Words"}),
        (["--without", "listener"], {"Words"}),
        (["--without", "talker"], set()),
        (["--only", "talker", "--only", "/listener"], {"Words"}),
    ],
)
def test_only_their_parts_of_the_marking_are_there(
    run: Run, model: Path, way: str, options: list[str], places: set[str]
) -> None:
    result = run("run", model, way, "--timeout", 0.5, "--json", *options)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert (set(said["marking"]), said["missing"]) == (places, [])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--only", "talkr"], "did you mean 'talker'"),
        (["--without", "nobody"], "there is no node 'nobody'"),
        (["--without", "talker", "--without", "listener"], "no node remains to be run"),
        (["--only", "talker", "--monitor"], "--monitor needs all nodes"),
        (["--only", "listener", "--until", "Words = 0"], "Words"),
    ],
)
def test_wrong_use(run: Run, model: Path, options: list[str], words: str) -> None:
    assert is_one_line_of_wrong_use(run("run", model, "--simulate", *options), words)


LISTENER = """
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("listener")
heard = []
node.create_subscription(String, "chatter", heard.append, 10)
while len(heard) < 3:
    rclpy.spin_once(node, timeout_sec=0.2)
open("heard", "w").write(str(len(heard)))
"""


@pytest.mark.long
def test_a_generated_node_runs_beside_one_that_exists(tmp_path: Path) -> None:
    model = talker()
    model.id = "greeting_in_strings"  # has other interfaces than the models of the name `greeting`
    (channel,) = model.channels
    channel.type = "std_msgs/msg/String"
    save(model, tmp_path / "greeting.sym.xmi")
    (tmp_path / "listener.py").write_text(LISTENER)
    (tmp_path / "handlers.py").write_text("def configure(net):\n    net.signal('Button').set(True)\n")
    command = [sys.executable, "-m", "dineros.cli.main", "run", "greeting.sym.xmi", "--only", "talker"]
    command += ["--with", "python listener.py", "--reach", "memory", "--timeout", "20", "--json"]
    with on_ros():
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "heard").read_text() == "3"


@pytest.mark.parametrize("is_generated", [False, True])
def test_two_runs_of_a_model_build_its_interfaces_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_generated: bool
) -> None:
    """One run has a part of the nodes and another run the rest, started together for the first time."""
    held_by: list[Path] = []

    def build(workspace: Path) -> None:
        descriptor = os.open(workspace, os.O_RDONLY)
        with pytest.raises(BlockingIOError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.close(descriptor)
        held_by.append(workspace)

    monkeypatch.setattr(building, "build_interfaces", build)
    monkeypatch.setattr(building, "environment", lambda _: {})
    monkeypatch.setattr(ros, "cache_folder", lambda: tmp_path)
    if is_generated:
        generate(talker(), tmp_path / "ws", Options(source="talker.sym.xmi"))
        ros._workspace_processes(tmp_path / "ws")
    else:
        save(talker(), tmp_path / "talker.sym.xmi")
        application = application_of(tmp_path / "talker.sym.xmi", [], None)
        ros._model_processes(application, application.system_model(), tmp_path / "run")
    assert len(held_by) == 1


def test_models_with_one_id_and_other_interfaces_are_built_in_other_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise the second run replaces the interfaces that nodes of the first one use."""
    built: list[Path] = []
    monkeypatch.setattr(building, "build_interfaces", built.append)
    monkeypatch.setattr(building, "environment", lambda _: {})
    monkeypatch.setattr(ros, "cache_folder", lambda: tmp_path)
    same, other = talker(), talker()
    next(place for place in places(same) if place.tokens).tokens += 1  # no interface depends on it
    other.tokenType = sym.TokenType(id="Word", name="Word", fields=[sym.TokenField(name="text")])
    for number, model in enumerate((talker(), same, other)):
        path = tmp_path / f"{number}.sym.xmi"
        save(model, path)
        application = application_of(path, [], None)
        ros._model_processes(application, application.system_model(), tmp_path / "run")
    first, again, third = built
    assert first == again != third
    assert {folder.name.rpartition("-")[0] for folder in built} == {talker().id}
