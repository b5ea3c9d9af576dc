"""Input signals over HTTP: a server that lets others set them (push), and a client that polls (pull)."""

from dineros.runtime.bridges.rest_poll import RestPoll
from dineros.runtime.bridges.rest_server import RestServer, signals_app

__all__ = ["RestPoll", "RestServer", "signals_app"]
