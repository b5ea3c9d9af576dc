"""Facts of small packages that tests write."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent
from typing import Any

from dineros.sources.facts import Facts, NodeFact
from dineros.sources.reading import read_source

HEAD = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger
"""


def written(folder: Path, **files: str) -> Path:
    """Write files, whose names have ``__`` for a slash, and no ending; return the folder."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text))
    return folder


def facts_of(folder: Path, text: str, **files: str) -> Facts:
    """Return the facts of a program, after the usual imports, and of other files next to it."""
    return read_source(written(folder, program=HEAD + dedent(text), **files))


def node_of(folder: Path, body: str, after: str = "", before: str = "", **files: str) -> dict[str, Any]:
    """Return the facts of a node in JSON: `body` is that of its class, `after` follows it in the file."""
    main = after or "def main():\n    rclpy.init()\n    rclpy.spin(Robot())\n"
    text = f"{dedent(before)}\nclass Robot(Node):\n" + indented(body) + "\n" + dedent(main)
    found = facts_of(folder, text + '\nif __name__ == "__main__":\n    main()\n', **files)
    return one(found).to_json()


def indented(text: str) -> str:
    """Return a text four columns to the right."""
    return "\n".join(f"    {line}" if line else "" for line in dedent(text).splitlines())


def one(facts: Facts) -> NodeFact:
    """Return the only node."""
    (node,) = facts.nodes
    return node


def effects(node: dict[str, Any], callback: str) -> list[tuple[str, str, str]]:
    """Return what a callback does: what, on what, and when."""
    (found,) = [each for each in node["callbacks"] if each["name"] == callback]
    return [(each["do"], each["what"], each["when"]) for each in found["effects"]]


def details(node: dict[str, Any], callback: str) -> dict[str, Any]:
    """Return the only effect of a callback."""
    (found,) = [each for each in node["callbacks"] if each["name"] == callback]
    (effect,) = found["effects"]
    result: dict[str, Any] = effect
    return result
