"""Facts of small packages that tests write."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from random import Random
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


WORD = r"[A-Za-z_]\w{2,}"
"""A name in source code."""


def edit_a_line(file: Path, words: Sequence[str], random_: Random) -> None:
    """Copy a line of a file, put another name into it, or change its numbers."""
    lines = file.read_text().split("\n")
    at = random_.randrange(len(lines))
    choice = random_.randrange(3)
    if choice == 0:
        lines.insert(at, lines[random_.randrange(len(lines))])
    elif choice == 1:
        lines[at] = re.sub(WORD, lambda _: random_.choice(words), lines[at], count=1)
    else:
        lines[at] = re.sub(r"\d+", lambda found: str(int(found[0]) + 1), lines[at])
    file.write_text("\n".join(lines))
