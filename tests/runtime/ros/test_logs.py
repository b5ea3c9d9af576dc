"""What handlers log arrives in the logs of ROS, once: on the console, in ROS's files, on /rosout."""

from __future__ import annotations

import ast
import re

import pytest

from tests.runtime.ros.conftest import PATIENCE, Process, Ros

LOUD = '''
"""Logs in all ways, from the first letter on."""

import asyncio
import logging
import sys

logging.basicConfig(level=logging.DEBUG)  # as programs without ROS do
LOG = logging.getLogger("desk.stamps")
LOG.info("imported")


def configure(net):
    LOG.info("configured")

    @net.handler("TSend", thread=THREADED)
    def send(firing):
        if firing.data["number"] == 0:
            return
        LOG.debug("a debug")
        LOG.info("an info of %s", firing.transition)
        LOG.warning("a warning: grüße\\udc80 %s %d%%", "nul\\0", 5)
        LOG.error("an error\\nof two lines")
        LOG.critical("a critical")
        LOG.log(25, "a note")
        for level in (logging.INFO, logging.ERROR):
            LOG.log(level, "by number")
        logging.info("by the root")
        logging.getLogger("office").info("by its name")
        logging.getLogger("office.clerk").info("below its name")
        LOG.info("%d", "no number")  # a mistake, which must not disturb the firing
        asyncio.new_event_loop().close()  # asyncio logs this, as a debug
        try:
            raise ValueError("torn")
        except ValueError:
            LOG.exception("a failure")
'''
LINE = re.compile(r"^\[([A-Z]+)\] \[[0-9.]+\] \[([^]]*)\]: (.*)$", re.MULTILINE)
OPEN = {"signals.Open": True}


def started(
    ros: Ros, arguments: list[str] | None = None, *, level: str | None = None, threaded: bool = False
) -> Process:
    """Start the office, and wait until it has sent its letters."""
    parameters = {**OPEN, **({} if level is None else {"log_level": level})}
    office = ros.node("office", parameters, LOUD.replace("THREADED", str(threaded)), arguments or [])
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    return office


def lines(text: str, name: str = "office") -> list[tuple[str, str, str]]:
    """Return level, logger and first line of each message of a node in what it printed."""
    found = [match.groups() for match in LINE.finditer(text)]
    return [(level, logger, said) for level, logger, said in found if logger.startswith(name)]


def said(office: Process, name: str = "office") -> list[tuple[str, str]]:
    """End the office, and return level and first line of what `desk.stamps` said."""
    assert office.interrupt() == 0, office.output()
    return [
        (level, said)
        for level, logger, said in lines(office.output(), name)
        if logger == f"{name}.desk.stamps"
    ]


EXPECTED = [
    ("INFO", "office.desk.stamps", "imported"),
    ("INFO", "office.desk.stamps", "configured"),
    ("INFO", "office.desk.stamps", "an info of TSend"),
    ("WARN", "office.desk.stamps", "a warning: grüße\\udc80 nul\\x00 5%"),
    ("ERROR", "office.desk.stamps", "an error"),
    ("FATAL", "office.desk.stamps", "a critical"),
    ("INFO", "office.desk.stamps", "a note"),
    ("INFO", "office.desk.stamps", "by number"),
    ("ERROR", "office.desk.stamps", "by number"),
    ("INFO", "office", "by the root"),
    ("INFO", "office", "by its name"),
    ("INFO", "office.clerk", "below its name"),
    ("ERROR", "office.desk.stamps", "a failure"),
]


@pytest.mark.long
@pytest.mark.parametrize("threaded", [False, True])
def test_everything_once_with_its_level_and_logger(ros: Ros, threaded: bool) -> None:
    """On the console and in the file of the node, whichever thread the handler runs on."""
    office = started(ros, threaded=threaded)
    assert office.interrupt() == 0
    output = office.output()
    assert lines(output) == EXPECTED
    assert "\nof two lines\n" in output
    assert output.count("ValueError: torn") == 1
    assert output.count("Traceback (most recent call last)") == 2  # that, and the mistake
    assert "Message: '%d'" in output
    assert output.count("a critical") == 1
    assert [record["event"] for record in ros.records("office", "error")] == []
    (file,) = (
        path
        for path in (ros.folder / "ros/ros_log").iterdir()
        if path.is_file() and f"_{office.popen.pid}_" in path.name
    )
    assert lines(file.read_text()) == EXPECTED


def test_rosout_tells_where_it_was_logged(ros: Ros) -> None:
    """Under the child's name, with file, function and line of the handler's code."""
    office = started(ros)
    heard = ros.script(
        "import rclpy\n"
        "from rcl_interfaces.msg import Log\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "got = []\n"
        "kept = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "node.create_subscription(Log, '/rosout', got.append, kept)\n"
        "while not any('a failure' in log.msg for log in got):\n"
        "    rclpy.spin_once(node, timeout_sec=0.05)\n"
        "print([(l.level, l.name, l.msg, l.function, l.file, l.line) for l in got if 'office' in l.name])\n"
        "rclpy.shutdown()\n"
    )
    logs = ast.literal_eval(heard)
    numbers = {"INFO": 20, "WARN": 30, "ERROR": 40, "FATAL": 50}
    assert [(level, name, text.partition("\n")[0]) for level, name, text, *_ in logs] == [
        (numbers[level], name, text) for level, name, text in EXPECTED
    ]
    source = LOUD.replace("THREADED", "False").splitlines()
    assert [function for *_, function, _, _ in logs[:3]] == ["<module>", "configure", "send"]
    for _, _, text, _, file, line in logs:
        assert file == str(ros.folder / "office_handlers.py")
        assert "LOG." in source[line - 1] or "logging." in source[line - 1], text
    (failure,) = (text for _, _, text, *_ in logs if text.startswith("a failure"))
    assert failure.endswith("ValueError: torn")
    assert f'File "{ros.folder / "office_handlers.py"}"' in failure
    assert office.interrupt() == 0


def test_parameter_sets_the_level(ros: Ros) -> None:
    """A debug of a library is not an answer to that."""
    office = started(ros, level="debug")
    assert ("DEBUG", "a debug") in said(office)
    assert "asyncio" not in office.output()


def test_argument_of_ros_sets_the_level(ros: Ros) -> None:
    """It goes before the parameter, which configuration files give as well."""
    office = started(ros, ["--log-level", "warn"], level="debug")
    levels = {level for level, _ in said(office)}
    assert levels == {"WARN", "ERROR", "FATAL"}


def test_argument_of_ros_for_the_node(ros: Ros) -> None:
    """Under another name and namespace; that for another node changes nothing."""
    arguments = ["-r", "__ns:=/town", "-r", "__node:=counter"]
    levels = ["--log-level", "town.counter:=debug", "--log-level", "office:=fatal"]
    office = started(ros, [*arguments, *levels])
    assert ("DEBUG", "a debug") in said(office, "town.counter")
    assert "[rcl]" not in office.output()


def test_argument_of_ros_for_one_logger(ros: Ros) -> None:
    """One logger tells more, another less; a library tells what it was asked for."""
    told = ["office.desk:=error", "office.asyncio:=debug"]
    office = started(ros, [word for each in told for word in ("--log-level", each)])
    assert office.interrupt() == 0
    found = lines(office.output())
    assert {level for level, logger, _ in found if logger.startswith("office.desk")} == {"ERROR", "FATAL"}
    assert ("INFO", "office.clerk", "below its name") in found
    selectors = [(level, said) for level, logger, said in found if logger == "office.asyncio"]
    assert selectors
    assert all(level == "DEBUG" and said.startswith("Using selector") for level, said in selectors)


def test_handlers_that_fail_to_load_are_one_line(ros: Ros) -> None:
    office = ros.node("office", handlers="import logging\nno_such_name\n")
    assert office.popen.wait(PATIENCE) == 2
    assert "office_handlers.py:2: NameError" in office.output()
    assert "Traceback" not in office.output()
