"""Narrows a model by accepted proposals, and widens it until it explains the recording again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.observation.explaining import TOLERANCE, RecordingVerdict, explain
from dineros.observation.importing.assuming import TIMER, USUAL_PERIOD
from dineros.observation.importing.building import Imported, to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.measuring.proposing import TimeProposal
from dineros.observation.narrowing.calling import verbs_of
from dineros.observation.narrowing.measured import with_times
from dineros.observation.narrowing.proposals import Proposal, Verbs, timer_name
from dineros.observation.systems import ObservedNode, ObservedSystem, RecordedTopic, named

Messages = Callable[[], Iterable[tuple[str, int]]]


@dataclass(frozen=True)
class Narrowed:
    """The result of narrowing."""

    imported: Imported
    """The model."""
    given: Given
    """The facts given before and by the proposals."""
    accepted: tuple[Proposal, ...]
    """Proposals that hold in the model, some of them weakened from `always` to `sometimes`."""
    dropped: tuple[Proposal, ...]
    """What was accepted, and taken back: with it no run would show the recording."""
    verdict: RecordingVerdict
    """That the model explains the recording; unknown if it could not be decided."""
    times: tuple[TimeProposal, ...] = ()
    unheld: tuple[TimeProposal, ...] = ()
    """`times`, `unheld`: accepted times that callbacks of the model have, and those of callbacks that it does
    not have.
    """


def narrowed(
    system: ObservedSystem,
    recorded: Collection[RecordedTopic],
    messages: Messages,
    accepted: Iterable[Proposal],
    *,
    times: Sequence[TimeProposal] = (),
    given: Given | None = None,
    id: str = "observed",
    tolerance: float = TOLERANCE,
    midway: bool = False,
    budget: Budget = UNLIMITED,
) -> Narrowed:
    """Return a model of a system in which accepted proposals hold, and that explains the recording.

    If no run shows a message, the least certain proposal of its topic is weakened from always to sometimes,
    and then withdrawn; after those, the proposals of its nodes, and then the rest.
    Open behaviour explains any recording of the system, so this ends. Where it does not, as a node has more
    threads than given, it withdraws only what is needed to explain as many messages as possible.

    Parameters
    ----------
    system : ObservedSystem
        Nodes with their publishers and subscriptions.
    recorded : collection of RecordedTopic
        The recorded topics, and the events of services.
    messages : callable
        Gives the messages again: topic, or name of an event, and time in nanoseconds of each, in order of
        their times.
    accepted : iterable of Proposal
        What is to hold.
    times : sequence of TimeProposal
        Times that callbacks shall have, of those that are in the model.
    given : Given, optional
        What people say; it is kept, and of the callbacks that it describes nothing is changed.
    id, tolerance, midway, budget
        As for `to_model` and `explain`.
    """
    before = given or Given()
    kept, dropped = list(accepted), list[Proposal]()
    verbs = verbs_of(system, recorded, before)

    def made(held: Iterable[Proposal]) -> Narrowed:
        said, its_times = with_times(with_proposals(before, system, held, verbs), system, times)
        imported = to_model(system, said, id)
        verdict = explain(
            imported.model, recorded, messages(), tolerance=tolerance, midway=midway, budget=budget
        )
        rest = tuple(each for each in times if each not in its_times)
        return Narrowed(imported, said, tuple(kept), tuple(dropped), verdict, its_times, rest)

    found, most = made(kept), None
    while kept and found.verdict.status == "violated" and found.verdict.unexplained is not None:
        first = found.verdict.unexplained
        most = most or made(()).verdict
        if most.unexplained is not None and first.number >= most.unexplained.number:
            break
        _weaken(kept, dropped, first.topic)
        found = made(kept)
    return found


def with_proposals(
    given: Given, system: ObservedSystem, accepted: Iterable[Proposal], verbs: Verbs | None = None
) -> Given:
    """Return the given facts, and those of accepted proposals for callbacks without given facts.

    Nodes that continue while a service works, by `verbs`, do so in all their callbacks.
    """
    by_node: defaultdict[str, list[Proposal]] = defaultdict(list)
    for proposal in accepted:
        by_node[proposal.node].append(proposal)
    nodes = dict(given.nodes)
    asking = {node for node, _ in verbs or {}}
    for node in system.nodes:
        if node.name in by_node or node.name in asking:
            found = _NarrowedNode(node, given.node(node.name), by_node[node.name], verbs or {})
            nodes[node.name] = found.said()
    return replace(given, nodes=nodes)


class _NarrowedNode:
    """The facts given for one node, and those that proposals add."""

    def __init__(self, node: ObservedNode, said: GivenNode, accepted: list[Proposal], verbs: Verbs) -> None:
        self._node = node
        self._said = said
        self._about = {(each.callback, _step(each)): each for each in accepted if each.kind != "timer"}
        self._timers = {_step(each): each for each in accepted if each.kind == "timer"}
        self._traced_timers = {
            each.callback: each.period for each in accepted if each.period and each.kind != "never"
        }
        published = sorted({endpoint.topic for endpoint in node.publishers})
        asked = {each.name: verbs.get((node.name, each.name), "call") for each in node.clients}
        self._goes_on = [service for service, verb in asked.items() if verb == "send"]
        self._able = [
            *(Step("publish", topic) for topic in published),
            *(Step(verb, service) for service, verb in asked.items()),
        ]
        self._goals = tuple(
            Step(verb, each.name, "*") for each in node.action_clients for verb in ("goal", "cancel")
        )

    def said(self) -> GivenNode:
        callbacks = dict(self._said.callbacks)
        for name in sorted({endpoint.topic for endpoint in self._node.subscribers}):
            self._add(callbacks, name, self._steps(name, self._able))
        # Effects of other callbacks count as the node's own unless they are given.
        others = (*self._node.servers, *self._node.action_servers, *self._node.action_clients)
        for name in (*(each.name for each in others), *self._goes_on):
            self._add(callbacks, name, self._steps(name, self._unexplained()))
        timers = self._said.timers
        if timers is None:
            timers = {}
            left = self._unexplained()
            if left or self._goals:
                timers[TIMER] = USUAL_PERIOD
                self._add(callbacks, TIMER, self._woven([], left))
            for name, period in self._traced_timers.items():
                timers[name] = round(period, 6)
                self._add(callbacks, name, self._steps(name, self._able))
            for step, proposal in self._timers.items():
                name = timer_name(step.name)
                while name in timers:
                    name += "_"
                timers[name] = round(proposal.mean, 6)
                self._add(callbacks, name, (step,))
        # There are separate responses only if a callback continues in the meantime.
        sent = {step.name for each in callbacks.values() for step in each.does or () if step.verb == "send"}
        for name in self._goes_on:
            if name not in sent and name not in {each.name for each in others}:
                callbacks.pop(name, None)
        return replace(self._said, callbacks=callbacks, timers=timers)

    @staticmethod
    def _add(callbacks: dict[str, GivenCallback], name: str, steps: tuple[Step, ...]) -> None:
        before = callbacks.get(name, GivenCallback())
        if before.does is None:
            callbacks[name] = replace(before, does=steps)

    def _steps(self, callback: str, able: Iterable[Step]) -> tuple[Step, ...]:
        """Return the steps of a callback: accepted ones, and at any time the others that it can take."""
        decided = sorted(
            (proposal.mean, times, replace(step, times=times))
            for (name, step), proposal in self._about.items()
            if name == callback and proposal.kind != "never"
            for times in _times(proposal)
        )
        left = [each for each in able if (callback, each) not in self._about and each not in self._timers]
        return self._woven([step for _, _, step in decided], left)

    def _unexplained(self) -> list[Step]:
        """Return the steps that may have causes that recordings do not show."""
        whole, left = set[Step](), dict[Step, int]()
        for (_, step), each in self._about.items():
            if each.kind == "never":
                continue
            # Times show the joint effects of all callbacks; traces show the effects of each.
            if each.source == "tracing":
                left[step] = left.get(step, each.messages) - each.explained
            elif each.explained == each.messages:
                whole.add(step)
        whole |= {step for step, messages in left.items() if messages <= 0}
        return [step for step in self._able if step not in whole and step not in self._timers]

    def _woven(self, decided: list[Step], left: Iterable[Step]) -> tuple[Step, ...]:
        open_ones = (*(replace(step, times="*") for step in left), *self._goals)
        woven = list(open_ones)
        for step in decided:
            woven += [step, *open_ones]
        return tuple(woven)


def _step(proposal: Proposal) -> Step:
    return Step(proposal.verb, proposal.topic)


def _times(proposal: Proposal) -> tuple[str, ...]:
    """Return how often a step is taken in a run, in the notation of `Step`; `always` allows repetitions."""
    if proposal.repeats > 1:
        return ("", "*") if proposal.kind == "always" else ("*",)
    return ("",) if proposal.kind == "always" else ("?",)


def _weaken(kept: list[Proposal], dropped: list[Proposal], message: str) -> None:
    """Weaken the least certain proposal of a topic or service; otherwise of its nodes; otherwise of all."""
    topic = named(message)
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
