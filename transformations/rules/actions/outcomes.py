"""Queries about the outcomes of goals: the places of results at a server and at a client."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import exits
from dineros.transformations.language import Query


class Exits(Query):
    """The places of a server at which goals end, one for each of its outcomes."""

    eclass = pn.Place
    many = True
    _words = "outcomes of {}"

    @staticmethod
    def _answer(server: sym.ActionServerPort) -> list[pn.Place]:
        return list(exits(server))


class Fetched(Query):
    """The place of a client for results of one outcome; absent if it takes no such results."""

    eclass = pn.Place
    _words = "what {} does about {}"

    @staticmethod
    def _answer(client: sym.ActionClientPort, exit: pn.Place) -> pn.Place | None:
        assert client.channel is not None
        place: pn.Place | None = getattr(client, exits(client.channel.server)[exit])
        return place
