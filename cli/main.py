"""The command ``dineros``: finds the subcommands, and turns every error into one line and an exit status.

Exit statuses: 0 fine, 1 a property is violated or a check found something, 2 wrong use or bad input, 3
unknown (a budget was hit, or a search interrupted); 130 interrupted, 141 the reader of the output has ended.
"""

from __future__ import annotations

import gc
import os
import pkgutil
import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from io import TextIOWrapper
from typing import Any

import click

from dineros.cli import commands
from dineros.cli.failures import failed
from dineros.cli.options import COMPLETION_VARIABLE, Invocation, show_version, standard_options
from dineros.metamodel.errors import near_matches

INTERRUPTED = 130  # 128 + SIGINT, as shells have it


class Subcommands(click.Group):
    """The modules of `dineros.cli.commands`, each imported when it is asked for."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.params.extend(standard_options())

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all subcommands, sorted."""
        return sorted(_modules())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a subcommand; None if there is none of this name."""
        place = _modules().get(cmd_name)
        if place is None:
            return None
        command: click.Command = getattr(import_module(place), place.rpartition(".")[2])
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a subcommand. If there is none, the error names similar ones."""
        if args and args[0] not in self.list_commands(ctx) and not args[0].startswith("-"):
            hint = near_matches(args[0], self.list_commands(ctx))
            ctx.fail(f"No such command {args[0]!r}{f', {hint}' if hint else ''}")
        return super().resolve_command(ctx, args)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run the command line and exit; see `click.Command.main`."""
        if not standalone_mode or COMPLETION_VARIABLE in os.environ:
            return super().main(args, "dineros", complete_var, standalone_mode, **extra)
        is_alone = args is None  # else a caller owns the process
        status = self._status(sys.argv[1:] if args is None else list(args), is_alone)
        if is_alone:
            gc.freeze()  # the process ends: a last look for garbage would go through the whole model
        sys.exit(status)

    def _run(self, arguments: list[str], invocation: Invocation) -> int:
        try:
            with self.make_context("dineros", arguments, obj=invocation) as context:
                return int(self.invoke(context) or 0)
        except click.exceptions.Exit as finished:  # --help and --version
            return finished.exit_code

    def _status(self, arguments: list[str], is_alone: bool) -> int:
        """Run the command line; print at most one line if that fails."""
        debug = os.environ.get("DINEROS_DEBUG", "") not in ("", "0")
        invocation = Invocation(debug=debug, is_alone=is_alone)
        if isinstance(sys.stdout, TextIOWrapper):  # names of files and elements that no terminal can show
            sys.stdout.reconfigure(errors="backslashreplace")
        try:
            status = self._run(arguments, invocation)
            sys.stdout.flush()
            return status
        except (KeyboardInterrupt, EOFError, click.Abort):
            return INTERRUPTED
        except Exception as error:
            if isinstance(error.__cause__, KeyboardInterrupt):  # Python 3.11, while a class is made
                return INTERRUPTED
            return failed(error, invocation.debug)


@cache
def _modules() -> dict[str, str]:
    """Return the module of each subcommand, by its name."""
    found = pkgutil.walk_packages(commands.__path__, f"{commands.__name__}.")
    names = [module.name for module in found if not module.ispkg]
    # A command named by a keyword of Python has a module with one more underscore.
    return {name.rpartition(".")[2].rstrip("_").replace("_", "-"): name for name in names}


@click.group(
    cls=Subcommands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    no_args_is_help=False,
    epilog="`dineros COMMAND --help` shows a command's options and an example.",
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=show_version,
    help="Show the version.",
)
def main() -> None:
    """Model-driven, formally verified ROS applications, based on Petri nets."""


if __name__ == "__main__":
    main()
