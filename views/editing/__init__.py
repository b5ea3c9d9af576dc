"""The graphical editor: a model in Python, shown and changed by pages in a browser on this machine."""

from dineros.views.editing.serving import serve_editor

__all__ = ["serve_editor"]
