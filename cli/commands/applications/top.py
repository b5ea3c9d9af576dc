"""``dineros top``: a running application in the terminal."""

from __future__ import annotations

import click

from dineros.cli.options import command, flag, json_option, reach_options, value_option


@command(
    "dineros top",
    "dineros top --domain 7 --reach network",
    "dineros top --once --seconds 3 --json",
)
@reach_options("Which computers ROS messages can reach, as set for the nodes.")
@flag("--once", "Listen for --seconds, print the result once, and exit.")
@value_option(
    "--seconds S",
    "With --once: the number of seconds to listen.",
    type=click.FloatRange(0.1, 3600),
    default=3.0,
    show_default=True,
)
@json_option
def top(domain: int | None, reach: str, once: bool, seconds: float, as_json: bool) -> int:
    """Show the nodes of a running application: their states, queues, losses, and what waits for what.

    The data is what the nodes publish on /diagnostics once a second. Ctrl-C ends the command. With --once,
    the exit status is 1 if no node was found.
    """
    from dineros.cli.presentation.overviews import show_live, show_once
    from dineros.cli.running.running import domain_of
    from dineros.metamodel.errors import DinerosError

    if as_json and not once:
        raise DinerosError("--json needs --once", hint="--json prints one object and exits")
    chosen = domain_of(domain)
    return show_once(chosen, reach, seconds, as_json) if once else show_live(chosen, reach)  # type: ignore[arg-type]
