"""A model narrowed by proposals that were accepted, and widened until it explains the recording again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.observation.explaining import TOLERANCE, RecordingVerdict, explain
from dineros.observation.importing.building import Imported, to_model
from dineros.observation.importing.given import Given, GivenCallback, GivenNode, Step
from dineros.observation.importing.nodes import TIMER, USUAL_PERIOD
from dineros.observation.narrowing.proposals import Proposal
from dineros.observation.systems import ObservedNode, ObservedSystem, RecordedTopic

Messages = Callable[[], Iterable[tuple[str, int]]]


@dataclass(frozen=True)
class Narrowed:
    """What narrowing made.

    Attributes
    ----------
    imported : Imported
        The model.
    given : Given
        What is said of the system by what was given before and by the proposals.
    accepted : tuple of Proposal
        What holds in the model, some of them weaker than they were: `sometimes` instead of `always`.
    dropped : tuple of Proposal
        What was accepted, and taken back: with it no run would show the recording.
    verdict : RecordingVerdict
        That the model explains the recording; unknown where that could not be found out.
    """

    imported: Imported
    given: Given
    accepted: tuple[Proposal, ...]
    dropped: tuple[Proposal, ...]
    verdict: RecordingVerdict


def narrowed(
    system: ObservedSystem,
    recorded: Collection[RecordedTopic],
    messages: Messages,
    accepted: Iterable[Proposal],
    *,
    given: Given | None = None,
    id: str = "observed",
    tolerance: float = TOLERANCE,
    midway: bool = False,
    budget: Budget = UNLIMITED,
) -> Narrowed:
    """Return a model of a system in which accepted proposals hold, and that explains the recording.

    Where no run shows a message, what is least sure of its topic is weakened: from always to sometimes, and
    then taken back; if nothing of the kind is left, what was accepted of its nodes, and then the rest.
    Open behaviour explains any recording of the system, so this ends.

    Parameters
    ----------
    system : ObservedSystem
        Nodes with their publishers and subscriptions.
    recorded : collection of RecordedTopic
        The recorded topics.
    messages : callable
        Gives the messages anew: topic and time in nanoseconds of each, in order of their times.
    accepted : iterable of Proposal
        What is to hold.
    given : Given, optional
        What people say; it is kept, and of the callbacks that it describes nothing is changed.
    id, tolerance, midway, budget
        As for `to_model` and `explain`.
    """
    before = given or Given()
    kept, dropped = list(accepted), list[Proposal]()
    while True:
        said = with_proposals(before, system, kept)
        imported = to_model(system, said, id)
        verdict = explain(
            imported.model, recorded, messages(), tolerance=tolerance, midway=midway, budget=budget
        )
        first = verdict.unexplained
        if verdict.status != "violated" or first is None or not kept:
            return Narrowed(imported, said, tuple(kept), tuple(dropped), verdict)
        _weaken(kept, dropped, first.topic)


def with_proposals(given: Given, system: ObservedSystem, accepted: Iterable[Proposal]) -> Given:
    """Return what is given, and what accepted proposals say of the callbacks of which nothing is given."""
    by_node: defaultdict[str, list[Proposal]] = defaultdict(list)
    for proposal in accepted:
        by_node[proposal.node].append(proposal)
    nodes = dict(given.nodes)
    for node in system.nodes:
        if node.name in by_node:
            nodes[node.name] = _Node(node, given.node(node.name), by_node[node.name]).said()
    return replace(given, nodes=nodes)


class _Node:
    """What is said of one node, and what proposals add."""

    def __init__(self, node: ObservedNode, said: GivenNode, accepted: list[Proposal]) -> None:
        self._node = node
        self._said = said
        self._about = {(each.callback, each.topic): each for each in accepted if each.kind != "timer"}
        self._timers = {each.topic: each for each in accepted if each.kind == "timer"}
        self._published = sorted({endpoint.topic for endpoint in node.publishers})
        self._calls = tuple(Step("call", each.name, "*") for each in node.clients) + tuple(
            Step(verb, each.name, "*") for each in node.action_clients for verb in ("send", "cancel")
        )

    def said(self) -> GivenNode:
        callbacks = dict(self._said.callbacks)
        for name in sorted({endpoint.topic for endpoint in self._node.subscribers}):
            self._add(callbacks, name, self._steps(name))
        # What answers begin is the node's own as long as nobody gives it; then it stays as it is given.
        others = (*self._node.servers, *self._node.action_servers, *self._node.action_clients)
        for name in (each.name for each in others):
            self._add(callbacks, name, self._woven([], self._unexplained()))
        timers = self._said.timers
        if timers is None:
            timers = {}
            left = self._unexplained()
            if left or self._calls:
                timers[TIMER] = USUAL_PERIOD
                self._add(callbacks, TIMER, self._woven([], left))
            for topic, proposal in self._timers.items():
                name = f"{TIMER}_{topic.strip('/').replace('/', '_')}"
                timers[name] = round(proposal.mean, 6)
                self._add(callbacks, name, (Step("publish", topic),))
        return replace(self._said, callbacks=callbacks, timers=timers)

    @staticmethod
    def _add(callbacks: dict[str, GivenCallback], name: str, steps: tuple[Step, ...]) -> None:
        before = callbacks.get(name, GivenCallback())
        if before.does is None:
            callbacks[name] = replace(before, does=steps)

    def _steps(self, callback: str) -> tuple[Step, ...]:
        """Return what the callback of a subscription does: what is accepted, the rest at any time."""
        decided, left = [], []
        for topic in self._published:
            proposal = self._about.get((callback, topic))
            if proposal is not None:
                if proposal.kind != "never":
                    decided.append((proposal.mean, Step("publish", topic, _TIMES[proposal.kind])))
            elif topic not in self._timers:
                left.append(topic)
        return self._woven([step for _, step in sorted(decided, key=lambda one: one[0])], left)

    def _unexplained(self) -> list[str]:
        """Return the topics whose messages may come from something that no recording shows."""
        whole = {
            topic
            for topic in self._published
            if topic in self._timers
            or any(
                each.topic == topic and each.kind != "never" and each.explained == each.messages
                for each in self._about.values()
            )
        }
        return [topic for topic in self._published if topic not in whole]

    def _woven(self, decided: list[Step], left: Iterable[str]) -> tuple[Step, ...]:
        open_ones = (*(Step("publish", topic, "*") for topic in left), *self._calls)
        woven = list(open_ones)
        for step in decided:
            woven += [step, *open_ones]
        return tuple(woven)


_TIMES = {"always": "", "sometimes": "?"}


def _weaken(kept: list[Proposal], dropped: list[Proposal], topic: str) -> None:
    """Weaken what is least sure of a topic; where nothing is left, of its nodes; or else of all."""
    nodes = {each.node for each in kept if topic in (each.topic, each.callback)}
    choices = (
        [each for each in kept if each.topic == topic],
        [each for each in kept if each.node in nodes],
        kept,
    )
    weakest = min(next(choice for choice in choices if choice), key=lambda each: each.confidence)
    place = kept.index(weakest)
    if weakest.kind == "always":
        kept[place] = replace(weakest, kind="sometimes")
    else:
        dropped.append(kept.pop(place))
