"""Jobs of the editor in other processes: check, find, verify, generate and run, by commands of DiNeROS."""

from dineros.views.editing.working.jobs import Jobs

__all__ = ["Jobs"]
