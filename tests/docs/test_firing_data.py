"""What the guide and the modules of handlers say of `firing.data` is one thing, and true."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.runtime import Firing, Net
from tests.runtime.tiny import stepped, tiny

ROOT = Path(__file__).resolve().parents[2]
TRUTH = "`firing.data` is the data of the first token it takes; tokens that it puts back come last."


@pytest.mark.parametrize("path", ["docs/generators.md", "generators/templates/node/handlers.py.j2"])
def test_both_say_the_same(path: str) -> None:
    assert TRUTH in " ".join((ROOT / path).read_text(encoding="utf-8").split())


def test_it_is_so() -> None:
    marking = {"control": ['{"count": 1}'], "first": ['{"count": 2}'], "second": ['{"count": 3}']}
    net = Net(tiny({"go": "control first second -> control done"}, marking))
    seen: list[object] = []

    @net.handler("go")
    def note(firing: Firing) -> None:
        seen.append(firing.data["count"])

    with stepped(net) as (node, _):
        node.step()
    assert seen == [2]
