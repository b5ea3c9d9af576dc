"""What rules ask of callback pages: where callbacks begin and end, what they wait for, who is in a group."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    begins_callback,
    callback_page_of,
    group_or_node,
    is_awaited,
    members_of,
    threads_of,
)
from dineros.transformations.language.datatypes import TRUTH, WHOLE
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.expressions import Expression, Match

LANGUAGE.add(__name__)


class Callback(Expression):
    """The callback page that a place stands on; absent where it stands on none."""

    eclass = sym.CallbackPage

    def __init__(self, place: Expression) -> None:
        super().__init__(place)
        self.place = place

    def evaluate(self, match: Match) -> sym.CallbackPage | None:
        """Return it."""
        return callback_page_of(self.place.evaluate(match))

    def __str__(self) -> str:
        return f"callback around {self.place}"


class Beginnings(Expression):
    """The transitions by which the callback of a timer begins; others begin with what is taken."""

    eclass = pn.Transition
    many = True

    def __init__(self, page: Expression) -> None:
        super().__init__(page)
        self.page = page

    def evaluate(self, match: Match) -> list[pn.Transition]:
        """Return them."""
        page: sym.CallbackPage = self.page.evaluate(match)
        return Body(page).beginnings() if page.kind == sym.CallbackKind.timer else []

    def __str__(self) -> str:
        return f"what begins {self.page}"


class Ends(Beginnings):
    """The transitions of a callback page by which its callback ends; a server's ends with its response."""

    def evaluate(self, match: Match) -> list[pn.Transition]:
        """Return them."""
        page: sym.CallbackPage = self.page.evaluate(match)
        return [] if page.kind == sym.CallbackKind.server else Body(page).ends()

    def __str__(self) -> str:
        return f"what ends {self.page}"


class Group(Expression):
    """The callback group of a callback or client; its node net where it names none."""

    eclass = EObject

    def __init__(self, asking: Expression) -> None:
        super().__init__(asking)
        self.asking = asking

    def evaluate(self, match: Match) -> EObject | None:
        """Return it."""
        return group_or_node(self.asking.evaluate(match))

    def __str__(self) -> str:
        return f"group of {self.asking}"


class Members(Expression):
    """The callbacks and clients in a callback group, or in that of a node net."""

    eclass = EObject
    many = True

    def __init__(self, group: Expression) -> None:
        super().__init__(group)
        self.group = group

    def evaluate(self, match: Match) -> list[EObject]:
        """Return them."""
        return [*members_of(self.group.evaluate(match))]

    def __str__(self) -> str:
        return f"members of {self.group}"


class Threads(Expression):
    """How many threads the executor of a node net has."""

    datatype = WHOLE

    def __init__(self, node: Expression) -> None:
        super().__init__(node)
        self.node = node

    def evaluate(self, match: Match) -> int:
        """Return the number."""
        return threads_of(self.node.evaluate(match))

    def __str__(self) -> str:
        return f"threads of {self.node}"


class BeginsCallback(Expression):
    """Whether responses to a client begin a callback of their own."""

    datatype = TRUTH

    def __init__(self, client: Expression) -> None:
        super().__init__(client)
        self.client = client

    def evaluate(self, match: Match) -> bool:
        """Tell whether they do."""
        return begins_callback(self.client.evaluate(match))

    def __str__(self) -> str:
        return f"response to {self.client} begins a callback"


class Awaited(BeginsCallback):
    """Whether a client's callback gives its thread back while it waits for the response."""

    def evaluate(self, match: Match) -> bool:
        """Tell whether it does."""
        return is_awaited(self.client.evaluate(match))

    def __str__(self) -> str:
        return f"response to {self.client} is awaited"
