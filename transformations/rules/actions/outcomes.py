"""What rules ask of the outcomes of goals: where a server puts results, and where a client gets them."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import exits
from dineros.transformations.language.functions import Query


class Exits(Query):
    """The places of a server where goals end, one for each outcome that it has."""

    eclass = pn.Place
    many = True
    _words = "outcomes of {}"

    @staticmethod
    def _answer(server: sym.ActionServerPort) -> list[pn.Place]:
        return list(exits(server))


class Fetched(Query):
    """The place of a client that gets results of one outcome; absent where it fetches none."""

    eclass = pn.Place
    _words = "what {} does about {}"

    @staticmethod
    def _answer(client: sym.ActionClientPort, exit: pn.Place) -> pn.Place | None:
        assert client.channel is not None
        place: pn.Place | None = getattr(client, exits(client.channel.server)[exit])
        return place
