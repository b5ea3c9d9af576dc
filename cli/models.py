"""Reads the models of commands, changed by their `--set` options."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import filterfalse
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import note, warn, working
from dineros.cli.options import invocation

OTHER_QUEUES = "by the rules of ros1, but ROS 2 has other queues (check and run with --middleware ros2)"
RUNS_AS_ROS2 = (
    "runs by the rules of ros2, whose queues ROS 2 has; the model says ros1 (check it with --middleware ros2)"
)
_MIDDLEWARE = "middleware"
BY_HAND = "the model declares as written by hand: "

if TYPE_CHECKING:
    from dineros.metamodel import pn, sym
    from dineros.metamodel.constraints import Violation


def load(path: Path, settings: Sequence[str] = ()) -> pn.Net:
    """Read a model and change it; the result may be invalid.

    Parameters
    ----------
    path : Path
        A model file, whose suffix gives the format, or a generated workspace, which holds its system model.
    settings : sequence of str
        Values of `--set`.

    Raises
    ------
    DinerosError
        The file holds no model, the folder is not a workspace, or a setting does not fit the model.
    """
    from dineros.metamodel import files

    with working(f"Reading {path}"):
        if path.is_dir():
            from dineros.generators.workspace.building import manifest_of
            from dineros.generators.workspace.system_model import system_model_of

            model: pn.Net = system_model_of(path)
            done = manifest_of(path).settings  # as a trace of this workspace names them, too
            settings = [setting for setting in settings if setting not in done]
        else:
            model = files.load(path)
    note(f"read {path}")
    _show_remarks(model, path)
    change(model, path, settings)
    return model


def _show_remarks(model: pn.Net, path: Path) -> None:
    """Print deviations of the reader from the format, and how a net was unfolded."""
    from dineros.metamodel.colours.origins import origins_of
    from dineros.metamodel.errors import counted
    from dineros.metamodel.files.remarks import remarks_of

    if invocation().verbosity < 0:
        return
    origins = origins_of(model)
    if origins.places or origins.transitions:
        places, transitions = (
            counted(sum(map(len, each.values())), name)
            for each, name in ((origins.places, "place"), (origins.transitions, "transition"))
        )
        warn(f"{path}: note: the coloured net is unfolded to {places} and {transitions}")
    remarks = remarks_of(model)
    if remarks:
        warn(f"{path}: note: this is not standard PNML; read as a P/T net: {'; '.join(remarks)}")


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Let errors of the block that name no file be errors of a file."""
    from dineros.metamodel.errors import DinerosError, Location

    try:
        yield
    except DinerosError as error:
        error.location = error.location or Location(path)
        raise


def change(model: pn.Net, path: Path, settings: Iterable[str]) -> None:
    """Change a model by `--set`; raises `DinerosError` if a setting does not fit it."""
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.settings import apply

    for setting in settings:
        try:
            apply(model, setting)
        except DinerosError as error:
            error.location = Location(path)  # the setting is not in a file; its model is
            raise
        note(f"set {setting}")


def load_named(path: Path, settings: Sequence[str] = ()) -> pn.Net:
    """Read the model of the command line and change it; the result may be invalid.

    A Python program with a function `build` is run for it, which no file that a model or a trace names is.

    Raises
    ------
    DinerosError
        As `load`; or the program fails, or has no such parameter.
    """
    from dineros.metamodel.files.programs import is_of_parameter, is_program, load_program

    if not is_program(path):
        return load(path, settings)
    with errors_of(path), working(f"Running {path}"):
        model = load_program(path).model(filter(is_of_parameter, settings))
    note(f"built by {path}")
    change(model, path, filterfalse(is_of_parameter, settings))
    return model


def load_system(path: Path, settings: Sequence[str] = ()) -> sym.SystemModel:
    """Read a system model and change it; the result may be invalid.

    Raises
    ------
    DinerosError
        As `load`, or the file holds a model of another kind.
    """
    from dineros.metamodel import sym
    from dineros.metamodel.errors import DinerosError, Location, with_article

    model = load(path, settings)
    if not isinstance(model, sym.SystemModel):
        kind = "plain net" if type(model).__name__ == "Net" else type(model).__name__
        raise DinerosError(
            f"holds {with_article(kind)}, but this command needs a system model", location=Location(path)
        )
    return model


def load_valid_system(path: Path, settings: Sequence[str] = ()) -> sym.SystemModel:
    """Read a system model and change it; raises `DinerosError` as `load_system`, or if it is invalid."""
    model = load_system(path, settings)
    refuse_invalid(model, path)
    return model


def refuse_invalid(model: pn.Net, path: Path) -> None:
    """Check all constraints of the metamodels.

    Raises
    ------
    DinerosError
        There is an error; the message is that of the first one.
    """
    from dineros.metamodel.errors import DinerosError, Location

    errors = [violation for violation in violations_of(model) if violation.severity == "error"]
    if errors:
        others = f"; and {len(errors) - 1} more errors" if len(errors) > 1 else ""
        raise DinerosError(
            f"is not valid: {errors[0].message}{others}",
            location=errors[0].location or Location(path),
            hint=f"`dineros validate {shlex.quote(str(path))}` says how to fix it",
        )


def say_rules(model: pn.Net, path: Path) -> None:
    """Print by which rules a system model is flattened, if they are not those of the paper."""
    if _is_of_ros2(model) and invocation().verbosity >= 0:
        warn(f"{path}: by the rules of ros2: writer, reader and request histories, capacities")


def rules_of(model: pn.Net) -> dict[str, str]:
    """Return the rules for JSON; nothing if they are those of the paper."""
    return {"middleware": "ros2"} if _is_of_ros2(model) else {}


def settings_on_ros2(path: Path, settings: Sequence[str]) -> tuple[str, ...]:
    """Return the settings for a run on ROS 2, with the rules of ros2 for a system model.

    A setting of `middleware` takes precedence, and a workspace keeps the settings of its generation.

    Parameters
    ----------
    path : Path
        The file of a system model, or the folder of a workspace.
    settings : sequence of str
        Values of `--set` and `--middleware`.

    Raises
    ------
    DinerosError
        As `load_system`.
    """
    from dineros.metamodel import sym

    given = tuple(settings)
    if path.is_dir() or any(setting.partition("=")[0].strip() == _MIDDLEWARE for setting in given):
        return given
    model = load_system(path, given)
    if model.middleware == sym.Middleware.ros2 or not model.channels:
        return given
    return (*given, f"{_MIDDLEWARE}=ros2")


def say_rules_on_ros2(path: Path, said: Sequence[str], taken: Sequence[str]) -> None:
    """Print that a run on ROS 2 uses other rules than its model: the given and the used settings."""
    if tuple(said) != tuple(taken) and invocation().verbosity >= 0:
        warn(f"{path}: {RUNS_AS_ROS2}")


def say_what_runs(models: Iterable[pn.Net], path: Path) -> None:
    """Print how a run on ROS 2 differs from the rules of a model.

    `models`: the system model, or the runtime models of a workspace.
    """
    from dineros.metamodel import rtm, sym

    ports = (sym.PublisherPort, sym.SubscriberPort, rtm.PublisherPort, rtm.SubscriberPort)
    by_ros1 = (
        model
        for model in models
        if isinstance(model, (sym.SystemModel, rtm.RuntimeModel)) and model.middleware == sym.Middleware.ros1
    )
    if invocation().verbosity < 0:
        return
    if any(isinstance(part, ports) for model in by_ros1 for part in model.eAllContents()):
        warn(f"{path}: {OTHER_QUEUES}")


def say_what_is_by_hand(models: Iterable[pn.Net], path: Path) -> None:
    """Warn of nodes that are written by hand according to the model, and that run as nets."""
    from dineros.metamodel import sym
    from dineros.metamodel.elements import node_nets

    by_hand = [
        str(node.id)
        for model in models
        for node in node_nets(model)
        if node.execution == sym.Execution.callbacks
    ]
    if by_hand and invocation().verbosity >= 0:
        shown = ", ".join(by_hand[:3]) + (f" and {len(by_hand) - 3} more" if len(by_hand) > 3 else "")
        warn(f"{path}: {BY_HAND}{shown}; this run executes their nets, without an executor")


def _is_of_ros2(model: pn.Net) -> bool:
    from dineros.metamodel import sym

    return isinstance(model, sym.SystemModel) and model.middleware == sym.Middleware.ros2


def violations_of(model: pn.Net) -> list[Violation]:
    """Check all constraints of the metamodels."""
    from dineros.metamodel.constraints import validate

    with working("Checking the constraints"):
        return validate(model)


def refuse_settings_that_break(violations: Sequence[Violation], path: Path) -> None:
    """Accept violations that the model in the file also has without settings.

    Raises
    ------
    DinerosError
        The settings made the model violate a constraint.
    """
    from dineros.metamodel.errors import DinerosError, Location

    errors = [violation for violation in violations if violation.severity == "error"]
    if not errors:
        return
    before = {(violation.constraint, violation.message) for violation in violations_of(load(path))}
    for violation in errors:
        if (violation.constraint, violation.message) not in before:
            raise DinerosError(
                f"with --set, {violation.message}", location=Location(path), hint=violation.fix or None
            )
