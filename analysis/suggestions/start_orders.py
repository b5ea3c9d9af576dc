"""Start orders in which no message is lost because a node is not there yet, or not active yet.

Of all orders, those that do one thing after the other decide most: if each of them can lose a message,
so can all. A run that loses a message after the first few things condemns all orders that begin with
these.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Presence
from dineros.analysis.model.channels import ends_of
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.lifecycles.start_order import managed_nodes
from dineros.metamodel.settings import apply
from dineros.transformations.language.copying import deep_copy

QUESTIONS = (Boundedness(), Presence())
MOST_ORDERS = 1000
"""Orders that are checked, beyond which the search gives up."""

Thing = tuple[str, str]
"""``configure`` or ``activate``, and the id of a node net."""


@dataclass
class StartOrder:
    """In which order to bring nodes up."""

    faults: list[Finding] = field(default_factory=list)
    """What can be lost in the order that the model has."""
    order: list[Thing] = field(default_factory=list)
    """What to do, one after the other: ``configure`` or ``activate``, and which node net."""
    settings: tuple[str, ...] = ()
    """The same, as settings of the model."""
    is_found: bool = False
    """Whether nothing is lost in this order."""
    is_proved: bool = False
    """Whether it is proved that every order can lose something, if no order is found."""
    tried: int = 0
    """How many orders were checked."""
    proved: list[str] = field(default_factory=list)
    """What is proved of the model with this order."""
    reason: str = "not yet searched"
    """Why no order is found."""


def suggest_start_order(
    model: sym.SystemModel, budget: Budget = UNLIMITED, found: StartOrder | None = None
) -> StartOrder:
    """Return an order in which nothing is lost while the managed nodes of a model come up.

    What is lost later, when nodes are deactivated, cleaned up or shut down, is not a question of this order.

    Parameters
    ----------
    model : sym.SystemModel
        The model; it is not changed.
    budget : Budget, optional
        Of all searches together; its memory is that of each.
    found : StartOrder, optional
        Where to put the answer as it comes, for those who want it after an interruption.
    """
    found = StartOrder() if found is None else found
    search = _OrderSearch(model, budget.begun(), found)
    try:
        search.run()
    except BudgetExceededError as limit:
        found.reason = str(limit)
    return found


class _OrderSearch:
    """A search through total orders, in which what begins as a run that loses something is left out."""

    def __init__(self, model: sym.SystemModel, budget: Budget, found: StartOrder) -> None:
        self._budget, self._found = budget, found
        copied, _ = deep_copy(model)
        assert isinstance(copied, sym.SystemModel)
        self._model = copied
        for node in managed_nodes(copied):
            life = node.lifecycle
            assert life is not None
            life.deactivates = life.cleansUp = life.shutsDown = False
        self._nodes = _consumers_first(copied)
        self._condemned: set[tuple[Thing, ...]] = set()
        self._open = ""

    def run(self) -> None:
        """Check the order that the model has; if it loses messages, search for another one."""
        found = self._found
        own = check(self._model, self._budget, questions=QUESTIONS)
        found.faults = own.findings
        if not self._loses(own) and not own.unknown:
            found.is_found, found.proved, found.reason = True, own.proved, ""
            return
        for order in self._orders(()):
            if found.tried == MOST_ORDERS:
                found.reason = f"none of {MOST_ORDERS} orders is safe, and more were not tried"
                return
            self._budget.stage(f"start order {found.tried + 1}")
            self._budget.check_time()
            if self._is_safe(order):
                return
        found.is_proved = not self._open
        found.reason = self._open or "in every start order a message can be lost"

    def _orders(self, begun: tuple[Thing, ...]) -> Iterator[tuple[Thing, ...]]:
        """Yield the orders that begin so; first those in which all are configured before any is active."""
        if begun in self._condemned:
            return
        todo = [("configure", node) for node in self._nodes if ("configure", node) not in begun]
        todo += [
            ("activate", node)
            for node in self._nodes
            if ("configure", node) in begun and ("activate", node) not in begun
        ]
        if not todo:
            yield begun
        for thing in todo:
            # A fault found in an order may rule out this beginning, and shorter ones.
            if any(begun[:length] in self._condemned for length in range(len(begun) + 1)):
                return
            yield from self._orders((*begun, thing))

    def _is_safe(self, order: tuple[Thing, ...]) -> bool:
        settings = tuple(
            f"{node}.lifecycle.{what}Step={number}" for number, (what, node) in enumerate(order, 1)
        )
        for setting in settings:
            apply(self._model, setting)
        report = check(self._model, self._budget, questions=QUESTIONS)
        found = self._found
        found.tried += 1
        losses = self._loses(report)
        if losses:
            self._condemn(order, losses)
        elif report.unknown:
            self._open = self._open or str(report.unknown[0])
        else:
            found.order, found.settings, found.proved = list(order), settings, report.proved
            found.is_found, found.reason = True, ""
        return found.is_found

    @staticmethod
    def _loses(report: Report) -> list[Finding]:
        rules = {fault.rule for fault in Presence.faults}
        return [finding for finding in report.findings if finding.rule in rules]

    def _condemn(self, order: tuple[Thing, ...], losses: list[Finding]) -> None:
        """Leave out all orders that begin as the run of a loss does."""
        for loss in losses:
            done = 0
            if loss.witness is None:
                continue
            fired = {step.transition for step in loss.witness.steps}
            for number, (what, node) in enumerate(order, 1):
                done = number if f"{node}.{what}" in fired else done
            self._condemned.add(order[:done])


def _consumers_first(model: sym.SystemModel) -> list[str]:
    """Return the managed nodes, each after those that its messages and requests go to, as far as possible."""
    import networkx as nx  # takes a while to import

    goes_to: nx.DiGraph[str] = nx.DiGraph()
    goes_to.add_nodes_from(node.id for node in managed_nodes(model))
    for channel in model.channels:
        for sender, getter in product(*ends_of(channel)):
            one, other = node_net_of(sender), node_net_of(getter)
            if one is not None and other is not None and one.id in goes_to and other.id in goes_to:
                goes_to.add_edge(one.id, other.id)
    return list(nx.dfs_postorder_nodes(goes_to))
