"""``dineros completion``: the script that makes a shell complete `dineros`."""

from __future__ import annotations

import click

from dineros.cli.console import say_lines
from dineros.cli.options import COMPLETION_VARIABLE, command


@command(
    "dineros completion bash > ~/.local/share/bash-completion/completions/dineros",
    "dineros completion zsh > ~/.zfunc/_dineros",
    "dineros completion fish > ~/.config/fish/completions/dineros.fish",
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]), metavar="bash|zsh|fish")
def completion(shell: str) -> int:
    """Print the script that makes a shell complete commands, options and model files."""
    from click.shell_completion import get_completion_class

    root = click.get_current_context().find_root().command
    script = get_completion_class(shell)
    assert script is not None
    say_lines(script(root, {}, "dineros", COMPLETION_VARIABLE).source())
    return 0
