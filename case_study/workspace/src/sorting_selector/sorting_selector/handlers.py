"""What the node `/selector` does when its transitions fire: objects get their names and poses."""

from __future__ import annotations

from dineros.runtime import Net

from . import firings

_POSE = {"red": 0.1, "blue": 0.2, "green": 0.3}


def configure(net: Net) -> None:
    """Leave the net as it is."""


def _selected(color: str, token: firings.InputToken) -> firings.Outcome:
    return {
        "color": color,
        "name": f"{color}-{token.id}",  # the number of a token is never used again
        "pose": [_POSE[color], 0.0, 0.0, 0.0, 0.0, 0.0],
    }


@firings.on("SelectRed")
def select_red(firing: firings.SelectRedFiring) -> firings.Outcome:
    """RedObjects -> SortRed."""
    return _selected("red", firing.inputs["RedObjects"][0])


@firings.on("SelectBlue")
def select_blue(firing: firings.SelectBlueFiring) -> firings.Outcome:
    """BlueObjects -> SortBlue."""
    return _selected("blue", firing.inputs["BlueObjects"][0])


@firings.on("SelectGreen")
def select_green(firing: firings.SelectGreenFiring) -> firings.Outcome:
    """GreenObjects -> SortGreen."""
    return _selected("green", firing.inputs["GreenObjects"][0])
