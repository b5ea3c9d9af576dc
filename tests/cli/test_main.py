"""What holds for every command: help, errors in one line, exit statuses, a quick start."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from dineros.cli.main import main
from dineros.cli.options import ExampleCommand
from dineros.metamodel import sym
from dineros.metamodel.elements import node_nets
from dineros.metamodel.files import save
from dineros.metamodel.records import write_records
from tests.cli.conftest import Run
from tests.observation.measuring.camera import KnownRun
from tests.observation.measuring.camera import camera as watching
from tests.support.programs.bags import write_bag
from tests.support.programs.system_packages import require_for
from tests.support.programs.warm_commands import program
from tests.support.ros2_systems.managed_systems import camera
from tests.support.systems.door import door
from tests.support.systems.talker import talker
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of
from tests.support.traces import Trace

ROOT = Path(__file__).resolve().parents[2]
NAMES = main.list_commands(click.Context(main))
NODE = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.words = self.create_publisher(String, "/chatter", 10)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.words.publish(String())


def main():
    rclpy.init()
    rclpy.spin(Talker())
"""
SETUP = """\
from setuptools import setup

setup(
    name="talker",
    packages=["talker"],
    entry_points={"console_scripts": ["talker = talker.node:main"]},
)
"""
LAUNCH = """\
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("rviz", default_value="true"),
            Node(package="talker", executable="talker"),
        ]
    )
"""
HEAVY = {"pyecore", "lxml", "lark", "networkx", "rich", "pysat", "numpy", "jinja2"}


def the_command(name: str) -> ExampleCommand:
    found = main.get_command(click.Context(main), name)
    assert isinstance(found, ExampleCommand)
    return found


def test_help_lists_every_command(run: Run) -> None:
    result = run("--help")
    assert result.exit_code == 0
    assert {"completion", "convert", "validate"} <= set(NAMES)
    for name in NAMES:
        assert f"\n  {name} " in result.stdout


@pytest.mark.parametrize("name", NAMES)
def test_help_of_every_command_ends_with_its_examples(run: Run, name: str) -> None:
    result = run(name, "--help")
    examples = the_command(name).examples
    assert result.exit_code == 0
    assert examples
    assert result.stdout.endswith("".join(["Examples:\n", *(f"  {example}\n" for example in examples)]))


@pytest.mark.parametrize("name", NAMES)
def test_every_option_and_argument_explains_itself(name: str) -> None:
    for parameter in the_command(name).params:
        if isinstance(parameter, click.Option):
            assert parameter.help
            assert parameter.help.endswith(".")


@pytest.fixture(scope="session")
def desk(tmp_path_factory: pytest.TempPathFactory, warm: Path) -> Path:
    """A folder with what the examples start from: the model, witnesses, a recorded run, a workspace."""
    folder = tmp_path_factory.mktemp("desk")
    (folder / "sorting.sym.xmi").write_bytes((ROOT / "case_study/sorting.sym.xmi").read_bytes())
    (folder / "robot.sym.xmi").write_bytes((ROOT / "examples/callbacks/sensor_fixed.sym.xmi").read_bytes())
    managed = camera()
    for step, node in enumerate(reversed(node_nets(managed)), 1):  # those who listen come up first
        assert node.lifecycle is not None
        node.lifecycle.configureStep, node.lifecycle.activateStep = step, 3 + step
    save(managed, folder / "camera.sym.xmi")
    model = door()
    model.properties.append(sym.Property(id="Closes", text="fired(Close) only after fired(Open)"))
    save(model, folder / "door.sym.xmi")
    save(watching(), folder / "watch.sym.xmi")
    (folder / "watched").mkdir()
    for name, records in KnownRun(1, quick=True).records.items():
        write_records(folder / "watched" / f"{name}.jsonl", records)
    (folder / "our_templates").mkdir()
    rounds = range(0, 3_000_000_000, 100_000_000)
    pairs = (("/scans", 0), ("/dones", 20_000_000))
    write_bag(folder / "recording", [(topic, at + late) for at in rounds for topic, late in pairs])
    trace = Trace()
    scans, dones = (
        trace.publisher(trace.node(node), topic)
        for node, topic in (("/sensor", "/scans"), ("/mapper", "/dones"))
    )
    for _ in range(9):
        trace.publish(scans, thread=2)
        trace.publish(dones, thread=3)
    trace.write(folder / "trace")
    (folder / "seen.given.toml").write_text(
        '[topic."/scans"]\npublishers = ["/sensor"]\nsubscribers = ["/mapper"]\n'
        '[topic."/dones"]\npublishers = ["/mapper"]\n'
    )
    save(model_of(COUNTED[11].system, 0.01), folder / "chain.sym.xmi")
    (folder / "race.net").write_text("net race\ntr fast [1,2] p -> a\ntr slow [3,4] p -> b\npl p (1)\n")
    (folder / "camera.net").write_text(
        "net camera\ntr take [5,5] p -> p queue\ntr work [1,2] queue -> \npl p (1)\n"
    )
    (folder / "handler.net").write_text("net handler\ntr begin [1,2] p -> q\ntr end [3,4] q -> p\npl p (1)\n")
    write_package(folder / "src")
    dineros = executable(tmp_path_factory.mktemp("bin"), warm)
    for command in (
        "import --bag recording -o seen.sym.xmi",
        "find sorting.sym.xmi --enabled TPick -o pick.jsonl",
        "find sorting.sym.xmi --enabled TSafe -o place.jsonl",
        "find sorting.sym.xmi --signals none --enabled TSafe -o witness.jsonl",
        "run sorting.sym.xmi --simulate --seed 1 --trace run",
        "generate sorting.sym.xmi -o workspace",
        "import --source src --launch robot.launch.py -o coded.sym.xmi",
    ):
        subprocess.run([dineros, *command.split()], cwd=folder, check=True, capture_output=True)
    return folder


def executable(folder: Path, warm: Path) -> Path:
    """Write the command ``dineros`` into a folder: a fork of what serves at a socket."""
    command = folder / "dineros"
    command.write_text(program(warm), encoding="utf-8")
    command.chmod(0o755)
    return command


def write_package(folder: Path) -> None:
    """Write source code that the examples import: a package with one node, and a launch file."""
    package = folder / "talker"
    (package / "talker").mkdir(parents=True)
    (folder / "robot.launch.py").write_text(LAUNCH)
    (package / "package.xml").write_text("<package format='3'><name>talker</name></package>\n")
    (package / "setup.py").write_text(SETUP)
    (package / "talker" / "__init__.py").touch()
    (package / "talker" / "node.py").write_text(NODE)


ENDLESS = {"edit", "top"}
"""Commands that end when the user says so; `models/test_edit.py` and `test_overview.py` do."""


@pytest.mark.long
@pytest.mark.parametrize(
    "example",
    [
        example
        for name in NAMES
        if name not in ENDLESS
        for example in the_command(name).examples
        if "--graph" not in example  # `tests/observation/graph` does
    ],
)
def test_every_example_runs(example: str, desk: Path, tmp_path: Path, warm: Path) -> None:
    require_for(example)
    shutil.copytree(desk, tmp_path, dirs_exist_ok=True)
    for folder in (".local/share/bash-completion/completions", ".zfunc", ".config/fish/completions"):
        (tmp_path / folder).mkdir(parents=True)
    executable(tmp_path, warm)
    environment = {**os.environ, "HOME": str(tmp_path), "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    result = subprocess.run(
        ["bash", "-c", example], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    said = [line for line in result.stderr.splitlines(keepends=True) if "by the rules of ros" not in line]
    assert (result.returncode, "".join(said)) == (0, "")


def test_version(run: Run) -> None:
    result = run("--version")
    assert result.exit_code == 0
    assert result.stdout.startswith("dineros ")


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ([], "dineros: missing command (see dineros --help)"),
        (["vlidate", "x"], "did you mean 'validate'?"),
        (["--nonsense"], "no such option"),
        (["validate"], "dineros validate: missing argument 'MODEL' (see dineros validate --help)"),
        (["validate", "a.xmi", "b.xmi"], "unexpected extra argument"),
        (["validate", "a.xmi", "--set"], "'--set' requires an argument"),
        (["convert", "a.xmi"], "missing option '-o'"),
        (["completion", "csh"], "'csh' is not one of"),
    ],
)
def test_wrong_use_is_one_line_and_status_2(run: Run, arguments: list[str], part: str) -> None:
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert part in result.stderr
    assert result.stderr.count("\n") == 1


def test_an_unexpected_error_is_one_line_that_asks_for_a_report(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    _let_validate_raise(monkeypatch, ZeroDivisionError("a\nb"))
    result = run("validate", "model.xmi")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("dineros: unexpected ZeroDivisionError: a b (please report it")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments", [["--debug", "validate", "x.xmi"], ["validate", "x.xmi", "--debug"]])
def test_debug_adds_the_stack_trace(run: Run, monkeypatch: pytest.MonkeyPatch, arguments: list[str]) -> None:
    _let_validate_raise(monkeypatch, ZeroDivisionError("a"))
    result = run(*arguments)
    assert result.exit_code == 2
    assert "Traceback" in result.stderr


def test_debug_by_the_environment(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DINEROS_DEBUG", "1")
    result = run("validate", "missing.xmi")
    assert result.exit_code == 2
    assert "Traceback" in result.stderr


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (KeyboardInterrupt(), 130, ""),
        (BrokenPipeError(), 141, ""),
        (OSError(28, "No space left on device"), 2, "dineros: No space left on device\n"),
        (OSError(13, "Permission denied", "there"), 2, "there: Permission denied\n"),
    ],
)
def test_what_the_system_reports(
    run: Run, monkeypatch: pytest.MonkeyPatch, error: BaseException, status: int, line: str
) -> None:
    _let_validate_raise(monkeypatch, error)
    result = run("validate", "model.xmi")
    assert (result.exit_code, result.stdout, result.stderr) == (status, "", line)


def test_an_interrupt_while_a_class_is_made(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python 3.11 makes an error of its own of it."""
    error = RuntimeError("Error calling __set_name__")
    error.__cause__ = KeyboardInterrupt()
    _let_validate_raise(monkeypatch, error)
    result = run("validate", "model.xmi")
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "")


def _let_validate_raise(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("dineros.cli.commands.models.validate.load_named", fail)


@pytest.mark.parametrize("arguments", [["--help"], ["completion", "bash"], ["validate", "--help"]])
def test_a_reader_that_leaves_gets_no_complaint(arguments: list[str]) -> None:
    command = [sys.executable, "-m", "dineros.cli.main", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
    assert (process.returncode, errors) == (141, b"")


def test_names_that_no_terminal_can_show(tmp_path: Path) -> None:
    model = talker()
    model.pages[0].objects[0].id = "日本"
    path = tmp_path / os.fsdecode(b"\xff.xmi")
    save(model, path)
    command = [sys.executable, "-m", "dineros.cli.main", "validate", str(path), "--set", "日本.tokens=-1"]
    environment = {**os.environ, "PYTHONIOENCODING": "latin-1"}
    result = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (result.returncode, result.stderr) == (1, "")
    assert "\\udcff.xmi:" in result.stdout
    assert r"\u65e5\u672c" in result.stdout


def test_an_interrupt_ends_quietly() -> None:
    program = (
        "import signal, time, dineros.cli.commands.models.validate as validate\n"
        # A shell's background job, as CI may be, starts with interrupts ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from dineros.cli.main import main\n"
        "def load(*_):\n"
        "    print('ready', flush=True)\n"
        "    time.sleep(60)\n"
        "validate.load_named = load\n"
        "main(['validate', 'model.xmi'])\n"
    )
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        errors = process.stderr.read()
    assert (process.returncode, errors) == (130, b"")


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import json, sys\n"
        "from dineros.cli.main import main\n"
        "try:\n"
        "    main(['--help'])\n"
        "except SystemExit:\n"
        "    print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})), file=sys.stderr)\n"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert HEAVY & set(json.loads(result.stderr)) == set()


@pytest.mark.parametrize(
    "command",
    [
        ("edit", "LOOP"),
        ("generate", "MODEL", "-o", "ws", "--templates", "loop"),
        ("flatten", "MODEL", "-o", "LOOP"),
        ("trace", "loop"),
        ("run", "MODEL", "--simulate", "--trace", "loop"),
    ],
    ids=lambda words: words[0],
)
def test_a_link_to_itself_is_an_error_of_one_line(
    run: Run, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("loop", "loop.sym.xmi"):
        Path(name).symlink_to(name)
    names = {"LOOP": "loop.sym.xmi", "MODEL": str(model)}
    ended = run(*(names.get(word, word) for word in command))
    assert ended.exit_code == 2
    assert len(ended.stderr.splitlines()) == 1 and "unexpected" not in ended.stderr
