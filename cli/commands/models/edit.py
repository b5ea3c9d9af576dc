"""``dineros edit``: draws and changes a model in the browser."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from dineros.cli.console import say, summarise, working
from dineros.cli.options import ModelPath, flag
from dineros.cli.supervising import serving_command, within_limits
from dineros.metamodel.errors import counted


@serving_command("dineros edit sorting.sym.xmi", "dineros edit new.sym.xmi --no-browser --port 8400")
@click.argument("model", type=ModelPath())
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    help="The port; by default the last one used, or any free one.",
)
@flag("--no-browser", "Only print the address.")
def edit(model: Path, port: int, no_browser: bool) -> int:
    """Draw a model in the browser: a new one, or that of an .xmi or .pnml file.

    The page is served on this machine only, and only with the printed address. Changes are kept in a journal
    in the model's folder until the model is saved. Ctrl-C ends the editor with exit status 0.
    """
    from dineros.metamodel.editing import Document
    from dineros.views.editing import serve_editor

    with working(f"Reading {model}"), within_limits():
        document = Document(model)
    try:
        handle = serve_editor(document, port, own_program())
        try:
            if document.recovered:
                say(f"{counted(document.recovered, 'unsaved change')} restored from the journal")
            say(f"editing {model}: {handle.url}")
            if not no_browser:
                import webbrowser

                webbrowser.open(handle.url_for_command_line())
            handle.wait()
        except KeyboardInterrupt:
            pass
        finally:
            handle.stop()
        is_kept = not document.is_saved and document.undo_label is not None
    finally:
        document.close()
    summarise(f"{model}: not saved; the journal keeps the changes" if is_kept else f"{model}: saved")
    return 0


_MAIN = """\
from dineros.analysis.answers.processes import die_with
die_with({parent})
from dineros.cli.main import main
main()
"""


def own_program() -> list[str]:
    """Return the start of the command line of a process that runs ``dineros`` and ends with this one.

    Modules in the folder where it is started do not shadow installed ones.
    """
    return [sys.executable, "-P", "-c", _MAIN.format(parent=os.getpid())]
