"""Source code against a graph: what is missing on either side, and other names, types and qualities."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from dineros.metamodel.matching import Quality
from dineros.observation.differences.code import differences_of_code
from dineros.observation.systems import USUAL, Endpoint, ObservedNode, ObservedSystem, TopicEndpoint

BEST = Quality("bestEffort", "volatile", "automatic", None, None, None)
TALKER = ObservedNode(
    "/talker",
    publishers=(TopicEndpoint("/word", "std_msgs/msg/String", USUAL, 10, "src/talker.py:7"),),
    clients=(Endpoint("/ask", "std_srvs/srv/Trigger", "src/talker.py:8"),),
)
CODE = ObservedSystem("src", (TALKER, ObservedNode("/idle")))


def compared(*nodes: ObservedNode) -> list[tuple[str, str, tuple[str, ...]]]:
    report = differences_of_code(CODE, ObservedSystem("graph", nodes))
    return [(each.rule, each.message, each.lines) for each in report.findings]


def test_what_agrees_is_proved() -> None:
    there = ObservedNode("/talker", (TopicEndpoint("/word", "std_msgs/msg/String"),), clients=TALKER.clients)
    report = differences_of_code(CODE, ObservedSystem("graph", (there, ObservedNode("/idle"))))
    assert (report.findings, len(report.proved)) == ([], 2)


def test_missing_nodes_on_either_side() -> None:
    assert compared(TALKER, ObservedNode("/other")) == [
        ("node-missing", "node /idle is missing", ()),
        ("node-extra", "the code has no node /other", ()),
    ]


@pytest.mark.parametrize(
    ("changed", "rule", "words"),
    [
        ({"type": "std_msgs/msg/Int32"}, "type-differs", "in the code std_msgs/msg/String"),
        ({"quality": BEST}, "quality-differs", "reliability bestEffort; in the code reliable"),
        ({"depth": 5}, "quality-differs", "depth 5; in the code 10"),
        (
            {"topic": "/words"},
            "port-missing",
            "node /talker has no publisher of /word (did you mean '/words'?)",
        ),
    ],
)
def test_ports_differ_at_lines_of_code(changed: dict[str, object], rule: str, words: str) -> None:
    port = replace(TALKER.publishers[0], **changed)  # type: ignore[arg-type]
    found = compared(replace(TALKER, publishers=(port,)), ObservedNode("/idle"))
    assert found[0][0] == rule and words in found[0][1] and found[0][2] == ("src/talker.py:7",)


def test_import_compares_code_with_a_graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from click.testing import CliRunner

    from dineros.cli.main import main
    from dineros.observation.graph import watching

    monkeypatch.chdir(tmp_path)
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "talker.py").write_text(
        "import rclpy\nfrom rclpy.node import Node\nfrom std_msgs.msg import String\n"
        "rclpy.init()\nnode = Node('talker')\nnode.create_publisher(String, 'word', 10)\nrclpy.spin(node)\n"
    )
    seen = ObservedSystem("graph", (ObservedNode("/talker"), ObservedNode("/more")))
    monkeypatch.setattr(watching, "watch", lambda *_, **__: seen)
    command = ["import", "-q", "--source", "src", "--graph", "-o", "a.sym.xmi"]
    found = CliRunner().invoke(main, command)
    assert found.exit_code == 1
    assert (
        "error: node /talker has no publisher of /word [port-missing]\n    at src/talker.py:6" in found.stdout
    )
    assert "error: the code has no node /more [node-extra]" in found.stdout
    assert 'id="more"' not in (tmp_path / "a.sym.xmi").read_text()
