"""What other processes do for the editor: check, answer, generate and run, by the commands of DiNeROS."""

from dineros.views.editing.working.jobs import Jobs

__all__ = ["Jobs"]
