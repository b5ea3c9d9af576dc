"""``dineros run``: runs an application; its nodes are supervised and recorded."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from dineros.cli.options import (
    command,
    flag,
    json_option,
    middleware_option,
    model_argument,
    path_option,
    reach_options,
    settings_option,
    value_option,
    values_option,
)


@command(
    "dineros run sorting.sym.xmi --simulate --seed 7",
    "dineros run sorting.sym.xmi --simulate --only feedback",
    "dineros run chain.sym.xmi --simulate --times --seed 7 --timeout 10",
    "dineros run sorting.sym.xmi --local --until 'RedObjects == 1' --timeout 60 --trace traces --monitor",
)
@model_argument()
@flag("--local", "Run all nodes in this process, on threads, without ROS.")
@flag("--simulate", "Like --local, in simulated time: the same seed gives the same run.")
@flag(
    "--times",
    "With --simulate: draw all times that the model declares, run no handlers, and print quantiles of "
    "response times and chains; 100 s, or --timeout.",
)
@path_option(
    "--report PAGE.html",
    "With --times: write a page with histograms and a timeline of the first part of the run.",
)
@value_option(
    "--speed X",
    "With --simulate: at most X simulated seconds a second, such as 1 to watch it; by default no limit.",
    type=click.FloatRange(0, min_open=True),
)
@value_option("--seed N", "Seed of the firing selections.", type=click.IntRange(0, 2**32 - 1))
@path_option(
    "--handlers FILE.py",
    "The handlers; by default handlers.py in the model's folder, if it exists.",
    into="handler_file",
)
@value_option("--until EXPR", "Stop when this condition holds, such as 'Shown >= 4'.")
@path_option("--trace DIR", "Write the nodes' traces to this folder.")
@value_option("--timeout S", "Stop after this number of seconds.", type=click.FloatRange(min=0))
@value_option(
    "--watchdog S",
    "Report a handler that blocks its node for this number of seconds, by default 10; 0: never.",
    type=click.FloatRange(0, 86400),
)
@values_option("--only NODE", "Run this node only; repeatable.")
@values_option("--without NODE", "Run all nodes except this one, which runs elsewhere; repeatable.")
@flag("--resume", "Resume from the traces in DIR.")
@flag("--monitor", "Replay the run on the model while it runs; end at a deviation.")
@flag("--view", "Serve a page on 127.0.0.1 that follows and steers the run.")
@values_option(
    "--with COMMAND",
    "Run this program as well, in the environment of the nodes; repeatable.",
    into="programs",
)
@click.option(
    "--restarts", type=click.IntRange(0), default=5, show_default=True, help="Restarts per minute and node."
)
@reach_options("Which computers ROS messages can reach.")
@values_option(
    "--stale-after SIGNAL=SECONDS[:THEN]",
    "Seconds after which this signal is stale if it was not set; then keep its value (keep), stop its "
    "node (stop), or set it to a value (true, false). Repeatable.",
)
@middleware_option
@settings_option
@json_option
def run(
    model: Path,
    local: bool,
    simulate: bool,
    times: bool,
    report: Path | None,
    speed: float | None,
    seed: int | None,
    handler_file: Path | None,
    until: str | None,
    trace: Path | None,
    timeout: float | None,
    watchdog: float | None,
    only: tuple[str, ...],
    without: tuple[str, ...],
    resume: bool,
    monitor: bool,
    view: bool,
    programs: tuple[str, ...],
    restarts: int,
    domain: int | None,
    reach: str,
    stale_after: tuple[str, ...],
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Run all nodes of a system model, or of a generated workspace, until --until, --timeout or Ctrl-C.

    Every node is a ROS 2 process of its own, unless --local or --simulate says otherwise; one that fails is
    started again and continues from its trace. On ROS 2 a model has the rules of ros2, unless --middleware
    says otherwise. MODEL is a system model or the folder of a workspace. Exit status: 1 where a step was not
    allowed or a failed handler halted a node, 2 where a node could not continue or never came up, 3 where
    time was over before --until held.
    """
    from dineros.cli.models import say_rules_on_ros2, say_what_is_by_hand, say_what_runs, settings_on_ros2
    from dineros.cli.presentation.runs import say_run
    from dineros.cli.running.applications import application_of, some_of
    from dineros.cli.running.running import domain_of, run_application
    from dineros.cli.running.watching import Options, RosOptions
    from dineros.metamodel.errors import DinerosError

    if resume and trace is None:
        raise DinerosError(
            "--resume needs the traces to continue from", hint="name their folder with --trace"
        )
    if programs and (local or simulate):
        raise DinerosError("--with needs ROS", hint="define simulate(application) in handlers.py instead")
    if speed is not None and not simulate:
        raise DinerosError("--speed needs --simulate", hint="only this option runs in simulated time")
    if times:
        return _simulate_times(model, settings, simulate, timeout, seed, report, as_json)
    if report is not None:
        raise DinerosError("--report needs --times", hint="`dineros trace` shows the traces of other runs")
    is_on_ros = not (local or simulate)
    if is_on_ros:
        said, settings = settings, settings_on_ros2(model, settings)
        say_rules_on_ros2(model, said, settings)
    application = application_of(model, settings, handler_file, stale_after)
    if only or without:
        if monitor:
            raise DinerosError("--monitor needs all nodes", hint="omit --only and --without")
        application = some_of(application, only, without)
    say_what_is_by_hand(application.models, model)
    if is_on_ros:
        say_what_runs(application.models, model)
    options = Options(
        until=until,
        timeout=timeout,
        trace=trace,
        seed=seed,
        watchdog=watchdog,
        is_resumed=resume,
        is_monitored=monitor,
        is_shown=view,
        ros=RosOptions(domain_of(domain), reach, programs, restarts) if is_on_ros else None,  # type: ignore[arg-type]
        is_simulated=simulate,
        speed=speed,
    )
    return run_application(application, options, partial(say_run, as_json=as_json))


def _simulate_times(
    model: Path,
    settings: tuple[str, ...],
    is_simulated: bool,
    timeout: float | None,
    seed: int | None,
    report: Path | None,
    as_json: bool,
) -> int:
    """Simulate only the times of a model; other options are rejected."""
    from dineros.cli.outputs import refuse_output
    from dineros.cli.presentation.reports.simulations import simulate_times_of
    from dineros.metamodel.errors import DinerosError

    context = click.get_current_context()
    known = {"model", "times", "simulate", "timeout", "seed", "settings", "as_json", "report"}
    default = click.core.ParameterSource.DEFAULT
    given = [name for name in context.params if context.get_parameter_source(name) != default]
    if not is_simulated:
        raise DinerosError("--times needs --simulate", hint="only simulation draws times from the model")
    for name in given:
        if name not in known and context.params[name] is not None and name in context.params:
            raise DinerosError(f"--times cannot be combined with --{name.replace('_', '-')}")
    if report is not None:
        refuse_output(report, (".html",))
    return simulate_times_of(model, settings, timeout, seed, report, as_json)
