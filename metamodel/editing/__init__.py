"""Changing a model step by step: typed commands, each with its exact inverse, in a journal next to the model.

A `Document` is a model file that is being edited. Commands come from anywhere (`commands`), are refused with
a reason or done as a whole (`editor`), can be undone to the byte (`changes`), survive a killed process
(`journal`), and are written back so that a file of somebody else keeps what was not changed (`storing`).
"""

from dineros.metamodel.editing.commands import Command, CommandError, decode_commands
from dineros.metamodel.editing.document import Document, Done

__all__ = ["Command", "CommandError", "Document", "Done", "decode_commands"]
