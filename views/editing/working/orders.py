"""Jobs that pages can request, and their command lines; a text from a page is always one argument."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from dineros.metamodel.editing import CommandError
from dineros.metamodel.files.confined import is_confined

Kind = Literal["check", "find", "verify", "generate", "run"]

LONGEST_QUESTION = 10_000
"""Limit of the characters of a formula."""

LONGEST_TIME = 86_400.0
"""Limit of the seconds of a job."""

SIGNALS = ("input-enabled", "fully-enabled", "io-enabled", "none")
WITNESS, TRACES = "witness.jsonl", "traces"
"""Names in the folder of a job: the witness of a finding, and the traces of a run."""


@dataclass(frozen=True)
class Order:
    """A requested job.

    Attributes
    ----------
    kind : {"check", "find", "verify", "generate", "run"}
        What.
    arguments : tuple of str
        Of ``dineros``; the model is left out, which comes after the first.
    words : str
        Its description.
    needs_file : bool
        Whether it is about the file as it is on the disk: what it makes stands next to that, or names it.
    workspace : str or None
        The folder next to the model that it is about in place of the model.
    """

    kind: Kind
    arguments: tuple[str, ...]
    words: str
    needs_file: bool = False
    workspace: str | None = None

    def line(self, model: Path, folder: Path) -> list[str]:
        """Return the arguments for a model, with a folder for the files of the job."""
        about = model if self.workspace is None else model.parent / self.workspace
        found = [self.kind, str(about), *self.arguments, "--json", "-v"]
        if self.kind in ("check", "find", "verify"):
            return [*found, "-o", str(folder / WITNESS)]
        return [*found, "--trace", str(folder / TRACES)] if self.kind == "run" else found


def order_of(said: Mapping[str, Any], beside: Path) -> Order:
    """Read the request of a page for a job.

    Parameters
    ----------
    said : mapping
        ``kind``, and the arguments of that kind.
    beside : Path
        The folder of the model: generated files are written there.

    Raises
    ------
    CommandError
        The request is not supported.
    """
    kind = said.get("kind")
    make = _KINDS.get(kind) if isinstance(kind, str) else None
    if make is None:
        raise CommandError(f"a job must be one of {', '.join(_KINDS)}")
    names, order = make
    for name in said:
        if name not in names | {"kind"}:
            raise CommandError(f"{kind} takes no {name[:100]!r}")
    return order(said, beside)


def _check(said: Mapping[str, Any], _: Path) -> Order:
    return Order("check", ("--no-cache", *_budget(said)), "check")


def _find(said: Mapping[str, Any], _: Path) -> Order:
    asked = _one_of(said, "enabled", "marking")
    text = _text(said, asked)
    options = (f"--{asked}={text}", *_signals(said), *_budget(said))
    return Order("find", options, f"find {text}" if asked == "marking" else f"find enabled({text})")


def _verify(said: Mapping[str, Any], _: Path) -> Order:
    logic = _one_of(said, "ltl", "ctl")
    text = _text(said, logic)
    options = (f"--{logic}={text}", "--no-cache", *_signals(said), *_budget(said))
    return Order("verify", options, f"verify {text}")


def _generate(said: Mapping[str, Any], beside: Path) -> Order:
    workspace, write = _workspace(said), said.get("write", False)
    if not isinstance(write, bool):
        raise CommandError("write must be true or false")
    options = ("-o", str(beside / workspace), *(() if write else ("--check",)))
    words = f"generate {workspace}" if write else f"what would change in {workspace}"
    return Order("generate", options, words, needs_file=True)


_HOW = {
    "simulate": ("simulated", ("--simulate",)),
    "local": ("local", ("--local",)),
    "ros": ("ROS 2", ()),
}


def _workspace(said: Mapping[str, Any]) -> str:
    workspace = said.get("workspace")
    if not isinstance(workspace, str) or not is_confined(workspace) or workspace.startswith("-"):
        raise CommandError("the workspace is a folder next to the model, such as workspace")
    return workspace


def _run(said: Mapping[str, Any], _: Path) -> Order:
    how = said.get("how")
    if not isinstance(how, str) or how not in _HOW:
        raise CommandError(f"the way to run an application must be one of {', '.join(_HOW)}")
    words, way = _HOW[how]
    options: list[str] = [*way, *_timeout(said), "--view"]
    if said.get("until") not in (None, ""):
        options.append(f"--until={_text(said, 'until')}")
    if how == "simulate" and (speed := said.get("speed")) is not None:
        options.append(f"--speed={_number(speed, 'speed', 1e6)}")
    if "workspace" not in said:
        return Order("run", tuple(options), f"run ({words})", needs_file=True)
    if how != "ros":
        raise CommandError("a workspace can only be run on ROS 2")
    name = _workspace(said)
    return Order("run", tuple(options), f"run {name} ({words})", needs_file=True, workspace=name)


_KINDS: dict[str, tuple[set[str], Callable[[Mapping[str, Any], Path], Order]]] = {
    "check": ({"timeout"}, _check),
    "find": ({"enabled", "marking", "signals", "timeout"}, _find),
    "verify": ({"ltl", "ctl", "signals", "timeout"}, _verify),
    "generate": ({"workspace", "write"}, _generate),
    "run": ({"how", "timeout", "until", "speed", "workspace"}, _run),
}


def _one_of(said: Mapping[str, Any], one: str, other: str) -> str:
    if (one in said) == (other in said):
        raise CommandError(f"give {one} or {other}")
    return one if one in said else other


def _text(said: Mapping[str, Any], name: str) -> str:
    text = said.get(name)
    if not isinstance(text, str) or not text.strip() or "\0" in text or len(text) > LONGEST_QUESTION:
        raise CommandError(f"{name} must be a string of 1 to {LONGEST_QUESTION:,} characters")
    return text


def _signals(said: Mapping[str, Any]) -> tuple[str, ...]:
    signals = said.get("signals", SIGNALS[0])
    if signals not in SIGNALS:
        raise CommandError(f"signals must be one of {', '.join(SIGNALS)}")
    return ("--signals", str(signals))


def _timeout(said: Mapping[str, Any]) -> tuple[str, str]:
    return "--timeout", str(_number(said.get("timeout", 60), "timeout", LONGEST_TIME))


def _budget(said: Mapping[str, Any]) -> tuple[str, ...]:
    return (*_timeout(said), "--memory", "2G")


def _number(found: object, name: str, most: float) -> float:
    if isinstance(found, bool) or not isinstance(found, (int, float)) or not 0 < found <= most:
        raise CommandError(f"{name} must be a number above 0, at most {most:,.0f}")
    return float(found)
