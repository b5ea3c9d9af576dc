"""Checks whether goals can hang, overtake each other, be canceled too late or never, or end unnoticed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.ways import can_fire, firing_witness, overtaking
from dineros.analysis.model.resting import shut_down_marks
from dineros.analysis.model.wording import outcome_words
from dineros.analysis.witnesses.findings import Fault
from dineros.analysis.witnesses.witness import Witness, witness_of, witness_to
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import holds_thread, runs_callbacks, threads_of
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.records import Accept, Cancel, Canceling, Finish, Outcome

if TYPE_CHECKING:
    from dineros.analysis.callbacks.refining import Ending
    from dineros.transformations.flattening.traces import Link

HANGS = Share(time=0.3)
"""Part of the time that is left for goals that wait forever; the rest is for what is asked after that."""

_HANGS = "whether goals can wait forever"
_ON_TIME = "no goal is canceled too late, and none overtakes another one"
_MORE_GOALS = "whether there are faults with more goals at once"
_ASSUMES = "a client does not wait for the end of a goal, and the answers assume that {assumption}"
_SET = "set its instances to the greatest number of goals that it works on at once"


@dataclass
class _Client:
    """What a client's goals are in the net: places and transitions by what they mean; ids."""

    channel: sym.ActionChannel
    port: sym.ActionClientPort
    waits: list[str] = field(default_factory=list)
    """Where a goal waits to be accepted."""
    works: dict[int, str] = field(default_factory=dict)
    """Where it is worked on, by slot."""
    accepts: dict[int, str] = field(default_factory=dict)
    ends: dict[int, list[str]] = field(default_factory=dict)
    asks: list[str] = field(default_factory=list)
    late: list[str] = field(default_factory=list)
    losses: list[str] = field(default_factory=list)
    """Transitions by which a goal, or its result, is lost."""
    overs: list[tuple[str, str]] = field(default_factory=list)
    """Where a result waits for the client, each with the outcome."""
    results: list[tuple[str, str]] = field(default_factory=list)
    """Transitions by which the client takes a result, each with the outcome."""

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the action, and of the place of the client's goals."""
        return (self.channel.id, self.port.goal.id)

    @property
    def words(self) -> str:
        """What messages call it."""
        return f"client {self.port.client}"


class Goals(Question):
    """Whether goals are accepted or refused, end in a way that their clients learn, and can be canceled."""

    NOT_ACCEPTED = Fault(
        "goal-never-accepted",
        "error",
        "A goal of an action can wait forever to be accepted.",
        "a goal of {client} of action {action} can wait forever to be accepted",
    )
    ENDLESS = Fault(
        "goal-never-ends",
        "error",
        "A goal of an action can be accepted and never be over.",
        "a goal of {client} of action {action} can be accepted and never be over",
    )
    LATE = Fault(
        "cancel-too-late",
        "note",
        "A request to cancel a goal can come when the goal is over.",
        "{client} of action {action} can ask to cancel too late: "
        "the goal is over before the server receives the request",
    )
    UNHEARD = Fault(
        "cancel-never-heard",
        "warning",
        "A request to cancel a goal never reaches its server.",
        "no request of {client} to cancel a goal of action {action} ever reaches the server{reason}",
    )
    OVERTAKEN = Fault(
        "goals-overtake",
        "note",
        "Of two goals of a client, the one accepted later can end first.",
        "goals of {client} of action {action} can overtake each other: one accepted later can end first",
    )
    NOT_FETCHED = Fault(
        "result-not-fetched",
        "warning",
        "A goal ends in a way that its client does not learn of.",
        "no client fetches the result if a goal of {client} of action {action} ends as {outcome}",
    )
    faults = (NOT_ACCEPTED, ENDLESS, LATE, UNHEARD, OVERTAKEN, NOT_FETCHED)
    asks = "the possible outcomes of goals"

    def ask(self, checked: Checked) -> None:
        """Look at the goals of each client of each action."""
        clients = list(_clients(checked))
        if not clients:
            return
        found = len(checked.report.findings) + len(checked.report.unknown)
        for client in clients:
            asks = f"the possible outcomes of goals of {client.words} of action {client.channel.action}"
            with checked.guarded(partial(checked.leave_open, asks)):
                self._fires(checked, client, self.LATE, client.late)
                unheard(checked, client)
                self._results(checked, client)
                self._overtaking(checked, client)
        if checked.firings is not None:
            if not checked.recurs:
                self._without_space(checked, clients, found)
            return
        with checked.guarded(partial(checked.leave_open, _HANGS)):
            share = HANGS.share(checked.budget)
            hangs = [self._hangs(checked, client, share) for client in clients]
            if not any(hangs):
                self._prove_ends(checked, clients)
            if len(checked.report.findings) + len(checked.report.unknown) == found:
                checked.report.proved.append(_ON_TIME)

    @staticmethod
    def _prove_ends(checked: Checked, clients: Sequence[_Client]) -> None:
        """Put into the report that no goal waits forever."""
        losses = [each for client in clients for each in client.losses]
        if can_fire(checked, losses) is False:
            checked.report.proved.append("every goal that was sent can end")
        else:
            checked.report.proved.append("every goal that is accepted can end")

    def _without_space(self, checked: Checked, clients: Sequence[_Client], before: int) -> None:
        """Look for goals that can wait forever in parts of the net.

        `before`: number of findings and open questions before the first question about goals.
        """
        from dineros.analysis.callbacks.refining import Endings, why_unknown

        if checked.subject.is_timed:
            checked.leave_open(_HANGS, checked.why_open or "it is not decided with times")
            return
        index = checked.subject.place_index
        waits = [
            (index[place],) for client in clients for _, places, _ in self._waits(client) for place in places
        ]
        endings = Endings(checked.subject.net).of_all(waits, HANGS.share(checked.budget))
        hangs = [self._hangs_in_parts(checked, client, endings) for client in clients]
        if None in hangs:
            checked.leave_open(_HANGS, why_unknown(endings.values()))
        elif not any(hangs):
            self._prove_ends(checked, clients)
            is_on_time = all(can_fire(checked, client.late) is False for client in clients)
            if is_on_time and len(checked.report.findings) + len(checked.report.unknown) == before:
                checked.report.proved.append(_ON_TIME)

    def _hangs_in_parts(
        self, checked: Checked, client: _Client, endings: Mapping[tuple[int, ...], Ending]
    ) -> bool | None:
        """Look for goals that never end from some marking on; None: it is not known whether there are any."""
        node = node_net_of(client.port.goal)
        can_leave = node is not None and node in shut_down_marks(checked.subject)
        hangs: bool | None = False
        for fault, places, parts in self._waits(client):
            for place in places:
                ending = endings[checked.subject.place_index[place],]
                if ending.status == "waits" and not (can_leave and fault is self.NOT_FETCHED):
                    self.add(checked, client, fault, witness_to(checked.subject, ending.trace), **parts)
                    hangs = True
                    break
                if ending.status != "ends" and hangs is False:
                    hangs = None
        return hangs

    def _waits(self, client: _Client) -> list[tuple[Fault, list[str], dict[str, str]]]:
        """Return the places where a goal waits, by the fault if it waits there forever."""
        return [
            (self.NOT_ACCEPTED, client.waits, {}),
            (self.ENDLESS, list(client.works.values()), {}),
            *((self.NOT_FETCHED, [place], {"outcome": outcome}) for place, outcome in client.overs),
        ]

    def _fires(self, checked: Checked, client: _Client, fault: Fault, transitions: list[str]) -> None:
        if can_fire(checked, transitions):
            self.add(checked, client, fault, firing_witness(checked, transitions))

    def _results(self, checked: Checked, client: _Client) -> None:
        for transition, outcome in client.results:
            if getattr(client.port, outcome) is None and can_fire(checked, [transition]):
                witness = firing_witness(checked, [transition])
                self.add(checked, client, self.NOT_FETCHED, witness, outcome=outcome)

    def _overtaking(self, checked: Checked, client: _Client) -> None:
        """Look for two goals of a client of which the later one ends first."""
        if (client.port.outstanding or 1) < 2 or len(client.works) < 2:
            return
        if checked.subject.is_timed:
            question = f"whether goals of {client.words} can overtake each other"
            checked.leave_open(question, "it is not decided with times", may_be_fault=False)
            return
        places, index = checked.subject.place_index, checked.subject.transition_index
        first, second = sorted(client.works)[:2]
        ends = frozenset(index[each] for each in client.ends[second])
        slots = places[client.works[first]], index[client.accepts[second]]
        way, is_all = overtaking(checked.subject.net, *slots, ends)
        if way is not None:
            self.add(checked, client, self.OVERTAKEN, witness_of(checked.subject, way))
        elif not is_all:
            question = f"whether goals of {client.words} can overtake each other"
            checked.leave_open(question, "there are too many markings")

    def _hangs(self, checked: Checked, client: _Client, budget: Budget) -> bool:
        """Look for goals that no marking ends from some marking on; return whether there are any."""
        from dineros.analysis.callbacks.blocking import last_parts, never_without, without
        from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets

        node = node_net_of(client.port.goal)  # once it is shut down, it fetches nothing, as it should be
        gone = None if node is None else shut_down_marks(checked.subject).get(node)
        sets, index = SymbolicSets(checked.space, budget=budget), checked.subject.place_index
        found = False
        for fault, places, parts in self._waits(client):
            stuck = next(filter(None, (never_without(sets, (index[place],)) for place in places)), None)
            if stuck is None:
                continue
            if gone is not None and fault is self.NOT_FETCHED:
                alive = sets.intersection(stuck, without(sets, (gone,)))
                if not alive:
                    continue
                trace = sets.way_to(alive)
            else:
                _, trace = next(last_parts(sets, stuck))
            self.add(checked, client, fault, witness_to(checked.subject, trace), **parts)
            found = True
        return found

    @staticmethod
    def add(checked: Checked, client: _Client, fault: Fault, witness: Witness | None, **parts: str) -> None:
        """Put a finding about a client's goals into the report."""
        words, action = client.words, client.channel.action
        checked.report.findings.append(
            fault.found(*client.elements, witness=witness, client=words, action=action, **parts)
        )


class Cancels(Question):
    """Whether servers receive cancel requests: the part of `Goals` that threads decide."""

    faults = (Goals.UNHEARD,)
    asks = "whether the server receives requests to cancel goals"

    def ask(self, checked: Checked) -> None:
        """Look at the goals of each client of each action."""
        for client in _clients(checked):
            unheard(checked, client)


def unheard(checked: Checked, client: _Client) -> None:
    """Find requests to cancel that can be made, of which the server never learns."""
    hears = [
        link.target.id
        for link in checked.subject.links()
        if link.meaning is not None and link.meaning.step is Canceling and client.channel in link.sources
    ]
    if not hears or not client.asks:
        return
    can_ask, can_hear = can_fire(checked, client.asks), can_fire(checked, hears)
    if can_ask and can_hear is False:
        reason, witness = _why_unheard(client.channel), firing_witness(checked, client.asks)
        Goals.add(checked, client, Goals.UNHEARD, witness, reason=reason)
    elif can_ask is not False and can_hear is None:
        question = f"whether a request of {client.words} to cancel a goal reaches the server"
        checked.leave_open(question, checked.why_open)


def qualify(checked: Checked) -> None:
    """Leave open what happens with more goals at once, if an action may get more than it has slots.

    What is proved then holds only under that assumption. A model of code cannot state the number of goals,
    so there it is an assumption of the answers, and no open question.
    """
    from dineros.analysis.questions.held_back import held_back

    checked.budget.stage(_MORE_GOALS)
    with checked.guarded(partial(checked.leave_open, _MORE_GOALS)):
        for each in held_back(checked.subject, checked.budget):
            server = node_net_of(each.slots.action.server.entry)
            if server is not None and server.sourceLine:
                checked.report.assumes.append(each.assumption)
            else:
                checked.leave_open(
                    f"whether there are faults if {each.words} works on more goals at once",
                    _ASSUMES.format(assumption=each.assumption),
                    _SET,
                )
            checked.report.assumed += checked.report.proved
            checked.report.proved.clear()


def _clients(checked: Checked) -> Iterator[_Client]:
    """Yield the clients of actions, with what the rules made for them."""
    if not isinstance(checked.model, sym.SystemModel):
        return
    found: dict[sym.ActionClientPort, _Client] = {}
    for channel in checked.model.channels:
        if isinstance(channel, sym.ActionChannel):
            found.update((port, _Client(channel, port)) for port in channel.clients)
    for link in checked.subject.links():
        port = next((source for source in link.sources if isinstance(source, sym.ActionClientPort)), None)
        if port in found and link.meaning is not None:
            _note(found[port], link)
    yield from found.values()


def _note(client: _Client, link: Link) -> None:
    meaning, id = link.meaning, link.target.id
    assert meaning is not None
    if isinstance(link.target, pn.Place):
        if meaning.part == "waits":
            client.waits.append(id)
        elif meaning.part == "works" and link.index is not None:
            client.works[link.index] = id
        elif meaning.part == "over":
            client.overs.append((id, outcome_words(link)))
        return
    if meaning.queue in ("goal", "result") and meaning.part in ("drop", "instead"):
        client.losses.append(id)
    if meaning.part == "too late":
        client.late.append(id)
    if meaning.step is Accept and link.index is not None:
        client.accepts[link.index] = id
    elif meaning.step is Finish and link.index is not None:
        client.ends.setdefault(link.index, []).append(id)
    elif meaning.step is Cancel and meaning.part == "ask":
        client.asks.append(id)
    elif meaning.step is Outcome:
        client.results.append((id, outcome_words(link)))


def _why_unheard(channel: sym.ActionChannel) -> str:
    """Return why a server receives no cancel requests, if its callbacks and threads are the reason."""
    page, node = channel.server.page, node_net_of(channel.server.page)
    if node is None or not runs_callbacks(node) or threads_of(node) > 1:
        return ""
    if not isinstance(page, sym.CallbackPage) or not holds_thread(page):
        return ""
    name = node.name or node.id
    return f": while a goal is executed, it holds the only thread of node net {name}"
