"""Edits a model step by step: typed commands with exact inverses, and a journal next to the model.

A `Document` is a model file that is being edited. Commands may come from any source (`commands`); they are
refused with a reason or executed completely (`editor`), can be undone exactly (`changes`), survive a killed
process (`journal`), and are written so that the unchanged parts of a file are preserved (`storing`).
"""

from dineros.metamodel.editing.commands import Command, CommandError, decode_commands
from dineros.metamodel.editing.document import Document, Done

__all__ = ["Command", "CommandError", "Document", "Done", "decode_commands"]
