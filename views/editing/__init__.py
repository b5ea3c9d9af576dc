"""The graphical editor: browser pages on this machine show and change a model in Python."""

from dineros.views.editing.serving import serve_editor

__all__ = ["serve_editor"]
