"""What rules ask of callback pages: where callbacks begin and end, what they wait for, who is in a group."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    begins_answer,
    begins_callback,
    callback_page_of,
    group_or_node,
    holds_thread,
    is_awaited,
    is_goal_awaited,
    members_of,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.calls import answers
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
    """The transitions by which a callback ends; a server's and a goal's end with what they answer."""

    def evaluate(self, match: Match) -> list[pn.Transition]:
        """Return them."""
        page: sym.CallbackPage = self.page.evaluate(match)
        return [] if page.kind == sym.CallbackKind.server or works_on_goals(page) else Body(page).ends()

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


class HoldsThread(BeginsCallback):
    """Whether a callback has a thread while it runs; `client` is its page."""

    def evaluate(self, match: Match) -> bool:
        """Tell whether it has."""
        return holds_thread(self.client.evaluate(match))

    def __str__(self) -> str:
        return f"{self.client} holds a thread"


class Steps(Beginnings):
    """The transitions of a callback that works on a goal and awaits at each step; others have none."""

    def evaluate(self, match: Match) -> list[pn.Transition]:
        """Return them."""
        page: sym.CallbackPage = self.page.evaluate(match)
        return [] if holds_thread(page) else Body(page).transitions

    def __str__(self) -> str:
        return f"steps of {self.page}"


class Told(Expression):
    """The place of an action's client that a transition tells of an answer or of feedback, if any."""

    eclass = pn.Place

    def __init__(self, client: Expression, move: Expression) -> None:
        super().__init__(client, move)
        self.client = client
        self.move = move

    def evaluate(self, match: Match) -> pn.Place | None:
        """Return it."""
        client: sym.ActionClientPort = self.client.evaluate(match)
        places = {*answers(client), client.feedback}
        move: pn.Transition = self.move.evaluate(match)
        return next((arc.target for arc in move.outgoing if arc.target in places), None)

    def __str__(self) -> str:
        return f"where {self.move} tells {self.client}"


class BeginsAnswer(Expression):
    """Whether what is told to an action's client begins a callback of its own."""

    datatype = TRUTH

    def __init__(self, client: Expression, move: Expression) -> None:
        super().__init__(client, move)
        self.client = client
        self.told = Told(client, move)

    def evaluate(self, match: Match) -> bool:
        """Tell whether it does."""
        return begins_answer(self.client.evaluate(match), self.told.evaluate(match))

    def __str__(self) -> str:
        return f"{self.told} begins a callback"


class GoalAwaited(BeginsCallback):
    """Whether the callback that sends a client's goals gives its thread back until they are over."""

    def evaluate(self, match: Match) -> bool:
        """Tell whether it does."""
        return is_goal_awaited(self.client.evaluate(match))

    def __str__(self) -> str:
        return f"goals of {self.client} are awaited"


class GoesOn(BeginsAnswer):
    """Whether a callback that awaits goes on with what is told: an answer on its own page."""

    def evaluate(self, match: Match) -> bool:
        """Tell whether it does."""
        client: sym.ActionClientPort = self.client.evaluate(match)
        place = self.told.evaluate(match)
        if place is None or place is client.feedback or not is_goal_awaited(client):
            return False
        return callback_page_of(place) is callback_page_of(client.goal)

    def __str__(self) -> str:
        return f"{self.client} awaits {self.told}"
