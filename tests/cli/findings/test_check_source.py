"""``check --source``: from folders of code to findings at their lines, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from lxml import etree

from dineros.cli.main import main

BATTERY = """
import rclpy, time
from rclpy.node import Node
from std_srvs.srv import Trigger
class Battery(Node):
    def __init__(self):
        super().__init__("battery")
        self.create_service(Trigger, "level", self.on_level)
    def on_level(self, request, response):
        time.sleep(5.0)  # SLEEPS
        return response
rclpy.init()
rclpy.spin(Battery())
"""
MONITOR = """
import rclpy
from rclpy.node import Node
from rclpy.executors import MultiThreadedExecutor
from std_srvs.srv import Trigger
from std_msgs.msg import String
class Monitor(Node):
    def __init__(self):
        super().__init__("monitor")
        self.level = self.create_client(Trigger, "level")
        self.pub = self.create_publisher(String, "said", 10)
        self.create_timer(0.5, self.tick)
    def tick(self):
        self.level.call(Trigger.Request())  # WAITS
        self.pub.publish(String())
rclpy.init()
executor = MultiThreadedExecutor(num_threads=4)
executor.add_node(Monitor())
executor.spin()
"""
TALKER = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.pub = self.create_publisher(String, "word", 2)
        self.create_timer(0.5, self.tick)
        HERE
    def tick(self):
        self.pub.publish(String())
        self.pub.publish(String())
        self.pub.publish(String())
    def on_word(self, message): pass
rclpy.init()
rclpy.spin(Talker())
"""
HEARS = 'self.create_subscription(String, "word", self.on_word, 2)'
LISTENER = f"""
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
class Listener(Node):
    def __init__(self):
        super().__init__("listener")
        {HEARS}
    def on_word(self, message): pass
rclpy.init()
rclpy.spin(Listener())
"""


def line_of(text: str, mark: str) -> int:
    """Return the number of the line with a mark."""
    return next(number for number, line in enumerate(text.split("\n"), 1) if mark in line)


def check(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["check", "-q", *arguments])


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a service that sleeps and a timer that hangs, in the current folder."""
    monkeypatch.chdir(tmp_path)
    folder = Path("src")
    folder.mkdir()
    (folder / "battery.py").write_text(BATTERY)
    (folder / "monitor.py").write_text(MONITOR)
    return folder


def test_text_and_json_name_lines(robot: Path) -> None:
    found = check("--source", "src")
    lines = found.stdout.splitlines()
    assert found.exit_code == 1 and not list(Path().glob("*.xmi"))
    at = next(number for number, line in enumerate(lines) if line.endswith("[callback-deadlock]"))
    assert lines[at + 1].startswith(f"    at src/monitor.py:{line_of(MONITOR, 'WAITS')}, ")
    at = next(number for number, line in enumerate(lines) if line.endswith("[code-sleeps]"))
    assert lines[at + 1] == f"    at src/battery.py:{line_of(BATTERY, 'SLEEPS')}"
    assert "note: 1 name without another end in this code; -v lists them" in lines
    code = {
        each["rule"]: each.get("code")
        for each in json.loads(check("--source", "src", "--json").stdout)["findings"]
    }
    assert code["code-sleeps"] == [f"src/battery.py:{line_of(BATTERY, 'SLEEPS')}"]


def test_sarif_and_junit_name_lines(robot: Path) -> None:
    wanted = {
        "code-sleeps": ("src/battery.py", line_of(BATTERY, "SLEEPS")),
        "callback-deadlock": ("src/monitor.py", line_of(MONITOR, "WAITS")),
    }
    (run,) = json.loads(check("--source", "src", "--format", "sarif").stdout)["runs"]
    places = {each["ruleId"]: each["locations"][0]["physicalLocation"] for each in run["results"]}
    cases = {
        case.get("classname"): case
        for case in etree.fromstring(check("--source", "src", "--format", "junit").stdout.encode()).iter(
            "testcase"
        )
    }
    for rule, (file, line) in wanted.items():
        assert places[rule]["artifactLocation"]["uri"] == file
        assert places[rule]["region"]["startLine"] == line
        case = cases[f"dineros.{rule}"]
        assert (case.get("file"), case.get("line")) == (file, str(line)) and case.find("failure") is not None
    meanings = {rule["id"]: rule["shortDescription"]["text"] for rule in run["tool"]["driver"]["rules"]}
    assert meanings["code-sleeps"] == "A callback sleeps a second or more."


def test_a_baseline_makes_it_a_gate_that_moved_lines_do_not_open(robot: Path) -> None:
    assert check("--source", "src", "--write-baseline", "known.json").exit_code == 0
    (robot / "battery.py").write_text(f"# one line more\n{BATTERY}")
    assert check("--source", "src", "--baseline", "known.json").exit_code == 0
    (robot / "monitor.py").write_text(MONITOR.replace("# WAITS", "; input('?')"))
    found = check("--source", "src", "--baseline", "known.json")
    assert found.exit_code == 1 and "waits for keyboard input [code-waits]" in found.stdout


def test_the_page_shows_the_code_around_each_line(robot: Path) -> None:
    (robot / "battery.py").write_text(BATTERY.replace("# SLEEPS", "# <b>SLEEPS</b>"))
    assert check("--source", "src", "-o", "report.html").exit_code == 1
    page = Path("report.html").read_text()
    number = line_of(BATTERY, "SLEEPS")
    assert f"<figcaption>src/battery.py:{number}</figcaption>" in page
    shown = "time.sleep(5.0)  # &lt;b&gt;SLEEPS&lt;/b&gt;</mark>"
    assert f"<mark><i>{number:5}</i>          {shown}" in page


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize("is_shared", [False, True], ids=["apart", "one executor"])
def test_overflows_that_durations_decide_are_notes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_shared: bool, times: int
) -> None:
    """In one executor, a callback that publishes more at once than the queue holds loses messages anyway."""
    monkeypatch.chdir(tmp_path)
    Path("src").mkdir()
    talker = TALKER.replace("        self.pub.publish(String())\n", "", 3 - times)
    Path("src/talker.py").write_text(talker.replace("HERE", HEARS if is_shared else "pass"))
    if not is_shared:
        Path("src/listener.py").write_text(LISTENER)
    found = check("--source", "src")
    is_certain = is_shared and times > 2
    assert ("[queue-overflow]" in found.stdout) == is_certain and found.exit_code == int(is_certain), (
        found.stdout
    )
    assert ("can overflow if callbacks take long enough" in found.stdout) != is_certain


def test_only_writers_in_the_executor_of_the_reader_make_an_overflow_certain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another program writes at its own time: a quick reader has taken what was there before."""
    monkeypatch.chdir(tmp_path)
    Path("src").mkdir()
    talker = TALKER.replace("        self.pub.publish(String())\n", "", 1)
    Path("src/talker.py").write_text(talker.replace("HERE", HEARS))
    Path("src/other.py").write_text(talker.replace("HERE", "pass").replace('"talker"', '"other"'))
    found = check("--source", "src")
    assert "[queue-overflow]" not in found.stdout and found.exit_code == 0, found.stdout
    assert "can overflow if callbacks take long enough" in found.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "name what to check: MODEL, or --source FOLDER"),
        (["--source", "nowhere"], "this folder of source code does not exist"),
        (["--source", ".", "a"], "'a' is not an ARG:=VALUE of a --launch FILE"),
        (["model.sym.xmi", "a:=b"], "'a:=b' is not an ARG:=VALUE of a --launch FILE"),
        (["model.sym.xmi", "--given", "a.toml"], "--given requires"),
        (["--source", ".", "-o", "found.jsonl"], "with --source, -o writes a report (.html) only"),
        (["--source", ".", "--certificate", "c.json"], "with --source, --certificate writes a report"),
    ],
)
def test_bad_input_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("model.sym.xmi").touch()
    found = check(*arguments)
    assert found.exit_code == 2 and said in found.stderr and len(found.stderr.splitlines()) == 1


def test_proofs_about_code_that_is_not_wholly_read_are_under_an_assumption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A port whose name or type is open may change everything: the model lacks it."""
    monkeypatch.chdir(tmp_path)
    quiet = TALKER.replace("HERE", "pass").replace("        self.pub.publish(String())\n", "", 2)
    Path("talker.py").write_text(quiet)
    whole = json.loads(check("--source", ".", "--format", "json").stdout)
    assert whole["proved"] and "assumed" not in whole
    more = 'self.other = self.create_client(sys.argv[1], "other")'
    Path("talker.py").write_text(quiet.replace("pass", more, 1))
    result = check("--source", ".", "--format", "json")
    part = json.loads(result.stdout)
    assert part["proved"] == [] and part["assumed"]
    (assumption,) = part["assumes"]
    assert assumption.startswith("what the model lacks changes nothing (1): talker.py:")


@pytest.mark.parametrize("file", ["saved.sym.xmi", "saved.sym.pnml"])
def test_a_saved_model_of_code_keeps_what_it_lacks(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each answer about all runs of a model states what the code has and the model lacks."""
    monkeypatch.chdir(tmp_path)
    quiet = TALKER.replace("HERE", 'self.other = self.create_client(sys.argv[1], "other")')
    Path("talker.py").write_text(quiet.replace("        self.pub.publish(String())\n", "", 2))
    of_code = json.loads(check("--source", ".", "--format", "json").stdout)
    assert of_code["proved"] == [] and of_code["assumed"] and of_code["assumes"]
    assert CliRunner().invoke(main, ["import", "--source", ".", "-o", file]).exit_code == 0
    saved = json.loads(check(file, "--format", "json").stdout)
    assert [saved[key] for key in ("proved", "assumed", "assumes")] == [
        of_code[key] for key in ("proved", "assumed", "assumes")
    ]
    table = ["--vary", "talker.threads=1", "-o", "table.csv"]
    for command in (
        ["verify", file, "--ctl", "AG (true)"],
        ["find", file, "--marking", "deadlock"],
        ["statespace", file],
        ["statespace", file, "--time"],
        ["sweep", file, *table],
    ):
        said = CliRunner().invoke(main, command).stdout.splitlines()
        assert [line for line in said if line.startswith("assumes: ")] == [f"assumes: {saved['assumes'][0]}"]


SERVES = """
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
class Asks(Node):
    def __init__(self):
        super().__init__("asks")
        self.client = self.create_client(Trigger, "ask")
class Serves(Node):
    def __init__(self, name):
        super().__init__(name)
        self.create_service(Trigger, "ask", self.answer)
    def answer(self, request, response): return response
"""
TOGETHER = """
rclpy.init()
executor = SingleThreadedExecutor()
executor.add_node(Asks())
executor.add_node(Serves("serves"))
executor.spin()
"""


def test_nodes_that_share_an_executor_have_their_own_names_in_findings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.py").write_text(SERVES + TOGETHER)
    Path("other.py").write_text(SERVES + 'rclpy.init()\nrclpy.spin(Serves("also_serves"))\n')
    found = check("--source", ".", "-v")
    assert "note: /ask has several servers: /also_serves, /serves; this matters if they run" in found.output


def test_programs_that_one_launch_file_starts_share_a_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("package.xml").write_text("<package><name>both</name></package>")
    Path("one.py").write_text(SERVES + 'rclpy.init()\nrclpy.spin(Serves("serves"))\n')
    Path("other.py").write_text(SERVES + 'rclpy.init()\nrclpy.spin(Serves("also_serves"))\n')
    nodes = "".join(f'<node pkg="both" exec="{each}.py"/>' for each in ("one", "other"))
    Path("both.launch.xml").write_text(f"<launch>{nodes}</launch>")
    found = check("--source", ".", "--launch", "both.launch.xml")
    assert "error: /ask has several servers: /also_serves, /serves [servers-share-name]" in found.stdout
