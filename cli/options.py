"""Common parts of subcommands: the class of commands with examples, the argument MODEL, the options."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import click
from click.shell_completion import CompletionItem

F = TypeVar("F", bound=Callable[..., Any])

COMPLETION_VARIABLE = "_DINEROS_COMPLETE"
"""Environment variable by which a shell requests completions."""


@dataclass
class Invocation:
    """Global options of one run of the command line."""

    debug: bool = False
    verbosity: int = 0
    """1 with `-v`, -1 with `-q`."""
    is_alone: bool = False
    """Whether the process exists only for this run only; else it is that of a program which calls the
    command.
    """
    is_watched: bool = False
    """Whether another process shows how far this one is."""


def invocation() -> Invocation:
    """Return the global options of the current run."""
    context = click.get_current_context(silent=True)
    found = context.find_object(Invocation) if context else None
    return found or Invocation()


class ExampleCommand(click.Command):
    """A command with the standard options, whose help ends with examples."""

    def __init__(self, *args: Any, examples: Sequence[str] = (), **options: Any) -> None:
        super().__init__(*args, **options)
        self.params.extend(self.own_options())
        self.examples = tuple(examples)

    def own_options(self) -> list[click.Option]:
        """Return the standard options, which do not depend on its function."""
        return standard_options()

    def invoke(self, ctx: click.Context) -> Any:
        """Run it; if the system has no memory, a command with a budget answers "unknown"."""
        try:
            return super().invoke(ctx)
        except MemoryError as error:
            from dineros.metamodel.errors import BudgetError, DinerosError

            has_budget = any(param.name == "memory" for param in self.params)
            raise (BudgetError if has_budget else DinerosError)(
                "memory ran out: the system gives this process no more",
                hint="make the model smaller, or see 'ulimit -a'",
            ) from error

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, one command line each."""
        super().format_epilog(ctx, formatter)
        if self.examples:
            with formatter.section("Examples"):
                for example in self.examples:
                    formatter.write(f"{'':{formatter.current_indent}}{example}\n")


def command(
    *examples: str, cls: type[ExampleCommand] = ExampleCommand
) -> Callable[[Callable[..., Any]], ExampleCommand]:
    """Register a function as the subcommand of its name, with `-q`, `-v` and `--debug`.

    `examples`: command lines for the end of its help; the tests run them.
    """

    def decorate(function: Callable[..., Any]) -> ExampleCommand:
        name = function.__name__.rstrip("_").replace("_", "-")  # that of a keyword of Python has one more
        return click.command(name, cls=cls, examples=examples)(function)

    return decorate


class ModelPath(click.Path):
    """A model file; completes to possible model files. Its existence is checked when it is read."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Offer model files and folders; if the folder has no model, offer all files."""
        from dineros.metamodel.files import SUFFIXES

        folder, _, start = incomplete.rpartition("/")
        shown = f"{folder}/" if "/" in incomplete else ""
        matches = []
        try:
            for path in sorted(Path(shown or ".").expanduser().iterdir()):
                if not path.name.startswith(start) or (path.name.startswith(".") and not start):
                    continue
                if path.is_dir():
                    matches.append(f"{shown}{path.name}/")
                elif path.suffix.lower() in SUFFIXES:
                    matches.append(f"{shown}{path.name}")
        except OSError:
            matches = []
        if not matches or (len(matches) == 1 and matches[0].endswith("/")):
            return [CompletionItem(incomplete, type="file")]  # the shell itself continues into the folder
        return [CompletionItem(match) for match in matches]


ANY_PATH = click.Path(path_type=Path)
"""A file or folder, which completes to all of them."""


class Adds(Protocol):
    """Adds options to a command's function."""

    def __call__(self, function: F, /) -> F:
        """Return the function, with the options."""


def together(*options: Adds) -> Adds:
    """Return a decorator that adds several options, in the order of the help."""

    def add(function: F, /) -> F:
        for option in reversed(options):
            function = option(function)
        return function

    return add


def collected(kind: type, into: str) -> Adds:
    """Pass the values of all options that are fields of a dataclass as one object of it."""
    names = [each.name for each in fields(kind)]

    def add(function: F, /) -> F:
        @wraps(function)
        def call(**values: Any) -> Any:
            made = kind(**{name: values.pop(name) for name in names})
            return function(**values, **{into: made})

        return cast(F, call)

    return add


def model_argument(*, required: bool = True) -> Adds:
    """Add the argument MODEL, passed as `model`."""
    return click.argument("model", type=ModelPath(), metavar="MODEL", required=required)


def flag(name: str, help: str, *, into: str | None = None) -> Adds:
    """Add an option without a value; `into` is its parameter, if its name is another one."""
    return click.option(*_names(name, into), is_flag=True, help=help)


def value_option(usage: str, help: str, *, into: str | None = None, **more: Any) -> Adds:
    """Add an option with a value.

    Parameters
    ----------
    usage : str
        The name and what help calls the value, such as ``--output FILE``.
    into : str, optional
        Its parameter, if its name is another one.
    **more
        As for `click.option`.
    """
    name, _, metavar = usage.partition(" ")
    return click.option(*_names(name, into), metavar=metavar, help=help, **more)


def values_option(usage: str, help: str, *, into: str | None = None) -> Adds:
    """Add an option that may be given several times; see `value_option`."""
    return value_option(usage, help, into=into, multiple=True)


def path_option(usage: str, help: str, *, into: str | None = None, **more: Any) -> Adds:
    """Add an option for a file or folder; see `value_option`."""
    return value_option(usage, help, into=into, type=ANY_PATH, **more)


def model_path_option(usage: str, help: str, *, into: str | None = None, **more: Any) -> Adds:
    """Add an option for a file, which completes as `ModelPath`; see `value_option`."""
    return value_option(usage, help, into=into, type=ModelPath(), **more)


def choice_option(
    name: str, choices: Sequence[str], help: str, *, into: str | None = None, default: str | None = None
) -> Adds:
    """Add an option with one of some values, by default the first one."""
    chosen = choices[0] if default is None else default
    return click.option(
        *_names(name, into), type=click.Choice(choices), default=chosen, show_default=True, help=help
    )


def _names(name: str, into: str | None) -> tuple[str, ...]:
    return (name,) if into is None else (name, into)


def output_option(
    help: str,
    *,
    metavar: str = "OUT",
    required: bool = False,
    type: click.Path | None = None,
    into: str = "output",
) -> Adds:
    """Add the option `-o`, a file or folder to write; by default, it completes as `ModelPath`."""
    kind = type or ModelPath()
    return click.option("-o", "--output", into, type=kind, metavar=metavar, required=required, help=help)


def format_option(what: str) -> Adds:
    """Add `--format`: how to print findings; `--json` is one of the formats."""
    formats = ("text", "json", "sarif", "junit")
    return choice_option("--format", formats, f"How to print {what}; CI shows SARIF and JUnit.")


def reach_options(how_far: str) -> Adds:
    """Add `--domain` and `--reach`: the reach of ROS messages."""
    return together(
        value_option("--domain N", "ROS domain; by default ROS_DOMAIN_ID.", type=click.IntRange(0, 101)),
        choice_option("--reach", ("memory", "machine", "network"), how_far, default="machine"),
    )


def rules_option(help: str) -> Adds:
    """Add the option `--rules`, a Python file with rules, passed as `rule_file`."""
    return path_option("--rules FILE.py", help, into="rule_file")


json_option: Adds = flag("--json", "Print one JSON object only.", into="as_json")


_MIDDLEWARE = f"{__name__}.middleware"


def _keep_middleware(context: click.Context, _: click.Parameter, given: str | None) -> None:
    context.meta[_MIDDLEWARE] = given


def _with_middleware(
    context: click.Context, _: click.Parameter, settings: tuple[str, ...]
) -> tuple[str, ...]:
    given = context.meta.get(_MIDDLEWARE)
    return settings if given is None else (*settings, f"middleware={given}")


middleware_option: Adds = click.option(
    "--middleware",
    type=click.Choice(("ros1", "ros2")),
    show_default="as the model says",
    is_eager=True,
    expose_value=False,
    callback=_keep_middleware,
    help="The queues of topics: those of the paper, or the histories of ROS 2 with capacities.",
)
"""An additional entry of `settings`, so that records and journals also name it."""

settings_option: Adds = value_option(
    "--set ELEMENT.FEATURE=VALUE",
    "Change the model for this run, such as RedObjects.tokens=2; repeatable.",
    into="settings",
    multiple=True,
    callback=_with_middleware,
)

theme_option: Adds = choice_option("--theme", ("light", "dark"), "Colours of .svg and .png.")

SIGNALS = ("none", "fully-enabled", "input-enabled", "io-enabled")
OVERFLOW = ("weighted", "inhibitor")

variant_options = together(
    middleware_option,
    choice_option("--signals", SIGNALS, "When a signal may change.", default="input-enabled"),
    choice_option(
        "--overflow",
        OVERFLOW,
        "How a full queue loses messages: by weighted arcs, for tools; by inhibitor arcs, for readers.",
    ),
)
"""The options of flattening a system model."""


def standard_options() -> list[click.Option]:
    """Return the options of every command.

    `invocation` has the values of `-q`, `-v` and `--debug`; `--limit` also holds for child processes.
    """
    limit = click.Option(
        ["--limit"],
        multiple=True,
        is_eager=True,
        expose_value=False,
        callback=_raise_limits,
        metavar="NAME=NUMBER",
        help="Raise a limit of sizes, such as instances=5000; repeatable.",
    )
    flags = [
        click.Option(names, is_flag=True, is_eager=True, expose_value=False, callback=_remember, help=help)
        for names, help in (
            (["-q", "--quiet"], "Print results only."),
            (["-v", "--verbose"], "Print more details."),
            (["--debug"], "Show the stack trace of an error (or set DINEROS_DEBUG=1)."),
        )
    ]
    return [limit, *flags]


def _raise_limits(ctx: click.Context, param: click.Parameter, texts: tuple[str, ...]) -> None:
    """Set limits until the command ends, in the environment, which started processes inherit."""
    from dineros.metamodel.errors import DinerosError
    from dineros.metamodel.limits import VARIABLE, raised

    if not texts:
        return
    before = os.environ.get(VARIABLE)
    try:
        os.environ[VARIABLE] = raised(texts)
    except DinerosError as error:
        raise click.BadParameter(str(error), ctx, param) from None

    def restore() -> None:
        if before is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = before

    ctx.call_on_close(restore)


def _remember(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if not value:
        return
    run = ctx.ensure_object(Invocation)
    if param.name == "debug":
        run.debug = True
    else:
        run.verbosity = 1 if param.name == "verbose" else -1


def show_version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    """Print the version and exit; the callback of `--version`."""
    if value and not ctx.resilient_parsing:
        from importlib.metadata import version

        click.echo(f"dineros {version('dineros')}")
        ctx.exit()


def cache_folder() -> Path:
    """Return the folder for caches: of the XDG base directories, otherwise ``~/.cache``."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "dineros"
