"""What rules ask of the outcomes of goals: where a server puts results, and where a client gets them."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import exits
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.expressions import Expression, Match

LANGUAGE.add(__name__)


class Exits(Expression):
    """The places of a server where goals end, one for each outcome that it has."""

    eclass = pn.Place
    many = True

    def __init__(self, server: Expression) -> None:
        super().__init__(server)
        self.server = server

    def evaluate(self, match: Match) -> list[pn.Place]:
        """Return them."""
        return list(exits(self.server.evaluate(match)))

    def __str__(self) -> str:
        return f"outcomes of {self.server}"


class Fetched(Expression):
    """The place of a client that gets results of one outcome; absent where it fetches none."""

    eclass = pn.Place

    def __init__(self, client: Expression, exit: Expression) -> None:
        super().__init__(client, exit)
        self.client = client
        self.exit = exit

    def evaluate(self, match: Match) -> pn.Place | None:
        """Return it."""
        client: sym.ActionClientPort = self.client.evaluate(match)
        assert client.channel is not None
        outcome = exits(client.channel.server)[self.exit.evaluate(match)]
        place: pn.Place | None = getattr(client, outcome)
        return place

    def __str__(self) -> str:
        return f"what {self.client} does about {self.exit}"
