"""What tests of commands share: small nets to run them on, and how to read what they print."""

from __future__ import annotations

import pytest
from click.testing import Result

from tests.support.programs.processes import Ended

NETS = {
    # Empties a into b; u is dead; three firings, then a deadlock.
    "ends": "net ends\npl a (3)\ntr t a -> b\ntr u c -> c\n",
    # Comes back.
    "cycle": "net cycle\npl idle (1)\ntr start idle -> busy\ntr stop busy -> idle\ntr wait idle -> idle\n",
    # b grows forever.
    "grows": "net grows\npl a (1)\ntr t a -> a b\n",
    # Some 1.3 million markings.
    "large": "net large\npl a (200)\ntr t a -> b\ntr u b -> c\ntr v c -> d\n",
}


def uses(name: str) -> pytest.MarkDecorator:
    """Let a test run on one of the nets."""
    return pytest.mark.parametrize("net", [name], indirect=True)


def lines(result: Result | Ended) -> list[str]:
    """Return the lines of a result on standard output."""
    return result.stdout.splitlines()


def is_one_line_of_wrong_use(result: Result | Ended, text: str) -> bool:
    """Tell whether a command refused its input in one line that holds a text."""
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    assert "report it" not in result.stderr
    return result.exit_code == 2 and result.stderr.count("\n") == 1 and text in result.stderr
