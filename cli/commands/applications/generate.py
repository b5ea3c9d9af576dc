"""``dineros generate``: a ROS 2 workspace from a system model, kept up to date with it."""

from __future__ import annotations

from pathlib import Path

import click

from dineros.cli.console import say_json, warn, working
from dineros.cli.models import (
    load_valid_system,
    say_rules_on_ros2,
    say_what_is_by_hand,
    say_what_runs,
    settings_on_ros2,
)
from dineros.cli.options import (
    ANY_PATH,
    flag,
    json_option,
    middleware_option,
    model_argument,
    output_option,
    path_option,
    settings_option,
    value_option,
)
from dineros.cli.presentation.workspaces import say_comparison
from dineros.cli.supervising import reading_command

FOUND = 1


@reading_command(
    "dineros generate sorting.sym.xmi -o workspace",
    "dineros generate sorting.sym.xmi -o workspace --check",
    "dineros generate sorting.sym.xmi -o workspace --templates our_templates --lifecycle",
    "dineros generate sorting.sym.xmi -o workspace --tests witness.jsonl",
    "dineros generate sorting.sym.xmi -o workspace --systemd --container",
)
@model_argument()
@output_option(
    "The workspace; the packages are written to its folder src/.",
    metavar="WORKSPACE",
    required=True,
    type=ANY_PATH,
    into="workspace",
)
@middleware_option
@settings_option
@flag("--check", "Write nothing; exit status 1 if a file is stale.")
@path_option(
    "--templates DIR",
    "Your own templates, which override the built-in ones file by file; give this option each time.",
)
@flag("--default-templates", "Return to the built-in templates.")
@click.option(
    "--lifecycle/--plain", default=None, help="Lifecycle nodes or plain nodes; stored in the workspace."
)
@click.option(
    "--systemd/--no-systemd",
    default=None,
    help="A systemd unit that runs the nodes; stored in the workspace.",
)
@click.option(
    "--container/--no-container",
    default=None,
    help="A Containerfile for podman or docker; stored in the workspace.",
)
@value_option("--maintainer 'NAME <ADDRESS>'", "Maintainer of the packages; stored in the workspace.")
@value_option("--license NAME", "Licence of the packages; stored in the workspace.", into="licence")
@path_option(
    "--tests TRACE",
    "Write a test that drives the nodes through a witness or a recorded run; repeatable.",
    multiple=True,
)
@json_option
def generate(
    model: Path,
    workspace: Path,
    settings: tuple[str, ...],
    check: bool,
    templates: Path | None,
    default_templates: bool,
    lifecycle: bool | None,
    systemd: bool | None,
    container: bool | None,
    maintainer: str | None,
    licence: str | None,
    tests: tuple[Path, ...],
    as_json: bool,
) -> int:
    """Generate a ROS 2 workspace from a system model, or bring one up to date.

    Each node net becomes a package with a module `handlers.py`, which developers edit: it is written once,
    and stubs for new transitions are added at its end. Everything else is generated again when the model
    changes. If such a file was edited, nothing is written and the differences are shown. The nodes have the
    rules of ros2 unless --middleware is given.
    """
    from dineros import generators

    if templates is not None and default_templates:
        raise click.UsageError("--templates and --default-templates exclude each other.")
    said, settings = settings, settings_on_ros2(model, settings)
    system = load_valid_system(model, settings)
    options = generators.Options(
        source=model.name,
        settings=settings,
        lifecycle=lifecycle,
        templates=templates,
        default_templates=default_templates,
        maintainer=maintainer,
        license=licence,
        systemd=systemd,
        container=container,
        tests=tests,
    )
    work = generators.check if check else generators.generate
    try:
        with working(f"Generating {workspace}"):
            comparison = work(system, workspace, options)
    except generators.EditedError as error:
        for edit in error.edits:
            warn(f"{edit.path} {edit.message}:")
            for line in edit.difference.splitlines():
                warn(line)
        raise
    if not check:
        say_what_is_by_hand([system], model)
        say_rules_on_ros2(model, said, settings)
        say_what_runs([system], model)
    if as_json:
        written = not check and bool(comparison.changes)
        stale = check and comparison.is_stale
        found = {"model": str(model), "workspace": str(workspace), "written": written, "stale": stale}
        say_json(found | comparison.to_dict())
    else:
        say_comparison(workspace, comparison, check)
    return FOUND if check and comparison.is_stale else 0
