"""The behaviour of a node in code: what its callbacks do, its groups, timers and threads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from dineros.observation.importing.assuming import of_client
from dineros.observation.importing.flows.deciding import Decisions
from dineros.observation.importing.flows.labels import Received, Step
from dineros.observation.importing.given import GivenCallback, GivenNode, OpenThreads
from dineros.observation.importing.groups.sharing import free_name
from dineros.observation.importing.groups.threads import threads_in_code
from dineros.observation.importing.of_code.node import CodedNode
from dineros.observation.importing.steps import Behaviour
from dineros.observation.importing.timing import order_of, sleeps_of, stops_of
from dineros.sources.facts import CallbackFact, Entity
from dineros.sources.libraries.requested import AT_ANY_TIME
from dineros.sources.places import Place

MAIN = "main"
"""Name of the timer that represents the actions of a node outside of callbacks."""
OVERLAPS = 2
"""Number of runs of an asynchronous callback in a reentrant group that the model has at once at most."""
_OUTSIDE = ("constructor", "main", "thread")
"""Kinds of code that runs outside of callbacks."""
_AT_ANY_TIME = ("event", "task")
"""Kinds of callbacks that are outside of callback groups, and may run at any time."""


def behaviour_of(node: CodedNode) -> GivenNode:
    """Return the behaviour of a node from the code."""
    return _Behaving(node).given()


class _Behaving:
    """Converts what the callbacks of a node do; parts that cannot be known are assumed."""

    def __init__(self, node: CodedNode) -> None:
        self._node, self._fact, self._names = node, node.fact, node.names
        self._at, self._taken, self._groups = node.at, node.taken, node.groups
        self._open_timers: set[str] = set()
        self._callbacks: dict[str, GivenCallback] = {}
        self._timers: dict[str, float] = {}
        self._behaviour = behaviour = Behaviour(
            node.names,
            node.taken,
            node.folder,
            node.fact.entities,
            self._groups_of_clients(),
            node.deciding,
        )
        self._decisions = Decisions(
            node.fact,
            node.names,
            behaviour.in_branch,
            behaviour.is_open,
            node.is_spun,
            node.folder,
            node.deciding,
        )

        self._node.modelled |= self._decisions.waits
        behaviour.modelled = self._node.modelled

    def given(self) -> GivenNode:
        """Return the node's behaviour from the code."""
        for entity, name in self._names.items():
            if entity.kind in ("subscriptions", "services"):
                self._callbacks[name] = self._callback(entity, entity.callbacks.get("callback"))
            elif entity.kind == "action_servers":
                self._callbacks[name] = self._callback(entity, entity.callbacks.get("execute"))
            elif entity.kind == "timers" and self._node.is_spun:
                self._timer(entity)
        served = set(self._callbacks)
        for entity, name in self._names.items():
            if entity.kind in ("clients", "action_clients"):
                steps = self._behaviour.after(entity, self._fact.callbacks)
                key = of_client(name) if name in served else name
                first = self._callbacks.get(key)
                if first is None:
                    self._callbacks[key] = GivenCallback(
                        steps,
                        self._groups.of(entity),
                        at=self._at(entity.at),
                        flow=self._decisions.after(entity),
                        accepted=self._decisions.told(entity, True),
                        rejected=self._decisions.told(entity, False),
                        has_open_group=self._groups.is_open(entity),
                    )
                else:  # several clients of one name are treated as one
                    both = None if steps is None or first.does is None else (*first.does, *steps)
                    self._callbacks[key] = replace(first, does=both)
        self._meanwhile()
        self._outside()
        threads, open_threads = self._threads()
        return GivenNode(
            threads=threads,
            groups=self._groups.kinds,
            answers_hold_groups=self._groups.answers_hold,
            timers=self._timers,
            callbacks=self._callbacks,
            newest=self._newest(),
            at=self._at(self._fact.at),
            order=None if self._groups.has_outside else order_of(self._fact),
            open_timers=frozenset(self._open_timers),
            variables=self._decisions.variables,
            open_threads=open_threads,
        )

    def _groups_of_clients(self) -> Mapping[Entity, str]:
        """Return the groups of clients that are in another one than the first client of their service."""
        first: dict[str, Entity] = {}
        found: dict[Entity, str] = {}
        for entity, name in self._names.items():
            if entity.kind == "clients" and self._fact.group_of(
                first.setdefault(name, entity)
            ) is not self._fact.group_of(entity):
                found[entity] = self._groups.of(entity) or ""
                words = "responses that no callback waits for are treated as those of the client of line"
                self._taken.add(f"{self._at(entity.at)}: {words} {first[name].at.line}")
        return found

    def _callback(self, entity: Entity, fact: CallbackFact | None) -> GivenCallback:
        if fact is None:
            steps: tuple[Step, ...] | None = None if "open" in str(entity.details) else ()
            has_open_group = self._groups.is_open(entity)
            return GivenCallback(
                steps,
                self._groups.of(entity),
                at=self._at(entity.at),
                has_open_group=has_open_group,
            )
        group, gives_back = self._groups.of(entity), self._behaviour.gives_back(fact)
        return GivenCallback(
            self._behaviour.steps(fact),
            group,
            gives_back,
            self._at(fact.at),
            sleeps_of(fact),
            overlaps=self._overlaps(entity, fact, group) if gives_back else None,
            flow=self._decisions.of(entity, "execute" if entity.kind == "action_servers" else "callback"),
            received=self._received(entity),
            has_open_group=self._groups.is_open(entity),
        )

    def _overlaps(self, entity: Entity, fact: CallbackFact, group: str | None) -> int | None:
        """Return how many runs of an asynchronous callback the model has at once; None: any number.

        rclpy begins further runs while others await, if the group is reentrant: as many as there are ticks or
        messages before a response comes.
        """
        if (
            entity.kind not in ("timers", "subscriptions")
            or self._groups.kinds.get(group or "") != "reentrant"
        ):
            return None
        words = (
            "awaits in a reentrant group: each tick or message begins a further run before others have ended"
        )
        self._taken.lack(f"{self._at(fact.at)}: {fact.name} {words}; in the model, at most {OVERLAPS} runs")
        return OVERLAPS

    def _received(self, entity: Entity) -> Received | None:
        """Return the branches of a subscription's callback, if a field of its message decides."""
        deciding = (
            self._node.deciding.get(self._names.get(entity, "")) if entity.kind == "subscriptions" else None
        )
        found = None if deciding is None else self._decisions.received(entity, deciding)
        if found is not None:
            words = (
                f"{found.name} decides; {self._names[entity]} is assumed to have the known publishers only"
            )
            self._taken.lack(f"{found.at}: {words}")  # another publisher may send other values
        return found

    def _timer(self, entity: Entity) -> None:
        fact = entity.callbacks.get("callback")
        said = fact.name if fact is not None else "timer"
        said = said.removeprefix("on_") if entity.details.get("period") == AT_ANY_TIME else said
        name = free_name(re.sub(r"\W+", "_", said).strip("_"), self._timers)
        period = entity.details.get("period")
        if period == AT_ANY_TIME:
            period = 1.0
            self._open_timers.add(name)
        elif not isinstance(period, (int, float)) or not 0 < period < 1e9:
            self._taken.add(f"{self._at(entity.at)}: the period of a timer is {period}; 1 s is assumed")
            period = 1.0
            self._open_timers.add(name)
        self._timers[name] = float(period)
        stops = stops_of(entity, self._fact)
        if stops is not None:
            line = f"{self._at(stops.at)}: {stops.words}; in the model it ticks at any time, and never stops"
            self._taken.lack(f"{line}: that it does is left out")
            self._open_timers.add(name)
        self._callbacks[name] = self._callback(entity, fact)

    def _meanwhile(self) -> None:
        """Add the callbacks that goals begin until they end: timers that tick at any time."""
        effects = (effect for fact in self._fact.callbacks for effect in fact.effects)
        for client, fact in {
            id(fact): (effect.entity, fact) for effect in effects for fact in effect.meanwhile
        }.values():
            steps = self._behaviour.steps(fact)
            if client not in self._names or steps == ():
                continue
            name = free_name(re.sub(r"\W+", "_", fact.name).strip("_") or fact.kind, self._timers)
            self._timers[name] = 1.0
            self._open_timers.add(name)
            self._callbacks[name] = GivenCallback(steps, self._groups.of(client), at=self._at(fact.at))

    def _outside(self) -> None:
        """Add the actions outside of callbacks: timers that tick at any time, each in a group of its own.

        One stands for constructors, the main function and threads. Each function that unknown code calls has
        its own: nothing says in which thread it runs, and what runs next to it.
        """
        own: list[Step] = []
        for fact in self._fact.callbacks:
            if fact.is_open and fact.at.file and fact.kind in (*_OUTSIDE, *_AT_ANY_TIME):
                words = f"not all that the {fact.kind} {fact.name} does could be read; omitted in the model"
                self._taken.lack(f"{self._at(fact.at)}: {words}")
            if fact.kind in _OUTSIDE:
                steps = _at_any_time(self._behaviour.steps(fact))
                paced = self._paced(fact) if steps else []
                own += [step for step in steps if step.at not in paced]
        if own:
            self._at_any_time(MAIN, own, self._fact.at)
        for fact in self._fact.callbacks:
            steps = _at_any_time(self._behaviour.steps(fact)) if fact.kind in _AT_ANY_TIME else []
            if steps:
                name = re.sub(r"\W+", "_", fact.name).strip("_") or "event"
                self._at_any_time(name, steps, fact.at)

    def _paced(self, fact: CallbackFact) -> list[str]:
        """Add a timer for each loop of a thread that sleeps in each turn; return where only these publish."""
        found: list[str] = []
        inside: set[int] = set()
        loops = [each for each in fact.effects if each.pace is not None and each.when == "always"]
        if fact.is_many or fact.kind == "constructor":
            return found
        for loop in loops:
            is_sure = bool(loop.how) and all(
                each.do == "publish" for each in fact.effects[: fact.effects.index(loop)]
            )
            steps = [
                replace(step, times=step.times or ("" if is_sure and is_certain else "?"))
                for effect, is_certain in dict(loop.turn).items()
                if (step := self._behaviour.in_branch(effect)) is not None
            ]
            if steps:
                name = free_name(re.sub(r"\W+", "_", fact.name).strip("_") or fact.kind, self._timers)
                self._timers[name] = loop.pace or 0.0
                self._callbacks[name] = GivenCallback(
                    tuple(steps), self._groups.outside(), at=self._at(loop.at)
                )
                inside |= {id(effect) for effect, _ in loop.turn}
                found += [step.at for step in steps]
        others = {self._at(each.at) for each in fact.effects if id(each) not in inside}
        return [each for each in found if each not in others]

    def _at_any_time(self, name: str, steps: list[Step], at: Place) -> None:
        name = free_name(name, self._timers)
        self._timers[name] = 1.0
        self._open_timers.add(name)
        done = tuple(dict.fromkeys(steps))
        self._callbacks[name] = GivenCallback(done, self._groups.outside(), at=self._at(at))

    def _threads(self) -> tuple[int | None, OpenThreads | None]:
        if self._node.is_spun:
            if self._fact.apart and (self._fact.pool or self._fact.threads != 1):
                names = ", ".join(self._fact.apart)
                words = f"{names} has threads of its own; in the model, all threads run all groups"
                self._taken.lack(f"{self._at(self._fact.at)}: {words}")
            return threads_in_code(self._fact, self._at(self._fact.at))
        self._taken.add(
            f"{self._at(self._fact.at)}: no executor spins node {self._node.name}: its callbacks never run"
        )
        return 1, None

    def _newest(self) -> Mapping[str, bool]:
        """Return the topics whose subscriptions request best-effort delivery, so that losses are intended."""
        return {
            self._names[entity]: True
            for entity in self._fact.of("subscriptions")
            if entity in self._names
            and self._node.is_spun
            and entity.details.get("reliability") == "best_effort"
        }


def _at_any_time(steps: tuple[Step, ...] | None) -> list[Step]:
    """Return steps that are taken or not, and that do not wait: the waits need no thread of an executor."""
    return [
        replace(
            step,
            verb="send" if step.verb == "call" else step.verb,
            times="?" if step.times == "" else step.times,
        )
        for step in steps or ()
        if step.verb not in ("accepted", "result")
    ]
