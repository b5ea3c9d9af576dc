"""What the selector does: pieces get their names and poses."""

from __future__ import annotations

from . import firings

POSES = {"red": 0.1, "blue": 0.2, "green": 0.3}


def _named(color: str, token: firings.InputToken) -> firings.Outcome:
    # The number of a token is never used again, also after a restart.
    return {"name": f"{color}-{token.id}", "color": color, "pose": [POSES[color], 0.0, 0.0, 0.0, 0.0, 0.0]}


@firings.on("ChooseRed")
def choose_red(firing: firings.ChooseRedFiring) -> firings.Outcome:
    """RedPieces -> ChosenRed."""
    return _named("red", firing.inputs["RedPieces"][0])


@firings.on("ChooseBlue")
def choose_blue(firing: firings.ChooseBlueFiring) -> firings.Outcome:
    """BluePieces -> ChosenBlue."""
    return _named("blue", firing.inputs["BluePieces"][0])


@firings.on("ChooseGreen")
def choose_green(firing: firings.ChooseGreenFiring) -> firings.Outcome:
    """GreenPieces -> ChosenGreen."""
    return _named("green", firing.inputs["GreenPieces"][0])
