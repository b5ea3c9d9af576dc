"""Selects the variables on which the callbacks of a node depend, and builds the flows of these callbacks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from dineros.observation.importing.flows.branching import Branching, Responses
from dineros.observation.importing.flows.goals import acceptance_after
from dineros.observation.importing.flows.graphs import either, passes, simplified, variables_of, without_marks
from dineros.observation.importing.flows.knowing import decided, followed, has_data
from dineros.observation.importing.flows.labels import (
    Ask,
    Deciding,
    Flow,
    GivenVariable,
    Label,
    Mark,
    Received,
    Step,
    of_service,
)
from dineros.sources.branches import Answered, conditions, variables_set
from dineros.sources.branches import Received as TestOfField
from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact, is_open
from dineros.sources.places import located
from dineros.sources.variables import Known, Variable, shown

MOST_EDGES = 400
"""Limit of the edges of the flow of one callback; variables of a larger one are omitted."""
_RESULT = Mark("asks for the result")
_MOST_CALLS = 3
"""Limit of the calls of one callback whose responses it distinguishes."""
_ONCE = ("conditional", "created_in", "instances", "via", "open")
"""Details of entities that may be missing, or several, or determined outside of the code."""


@dataclass(frozen=True)
class _Answers:
    """Callbacks that the responses of a client start, and whether each response starts one of them."""

    callbacks: tuple[CallbackFact, ...]
    is_certain: bool


class Decisions:
    """The variables of a node, and the flows of its callbacks.

    Parameters
    ----------
    names : mapping of Entity to str
        The entities that the model has.
    step : callable
        Returns the step of an effect in the model; None: it has none.
    is_open : callable
        Whether a callback may do anything.
    is_spun : bool
        Whether an executor runs the callbacks.
    folder : str
        In which the files are.
    fields : mapping of str to Deciding
        Fields of responses that decide, by the keys of the services.
    """

    def __init__(
        self,
        fact: NodeFact,
        names: Mapping[Entity, str],
        step: Callable[[Effect], Step | None],
        is_open: Callable[[CallbackFact], bool],
        is_spun: bool,
        folder: str = "",
        fields: Mapping[str, Deciding] | None = None,
    ) -> None:
        self._fields = fields or {}
        self._fact, self._names, self._step, self._is_open = fact, names, step, is_open
        self._folder = folder
        self._called = self._entities() if is_spun else {}
        self._answers = {
            (client, do): self._answers_of(client, do)
            for client in names
            for do in {"clients": ("call",), "action_clients": ("send_goal", "get_result")}.get(
                client.kind, ()
            )
            if is_spun
        }
        self._flows: dict[tuple[CallbackFact, bool | None], Flow] = {}
        self._known = self._followed_once()
        self._variables = self._certain()
        while self._variables and not self._is_settled():
            self._flows.clear()

    @property
    def variables(self) -> dict[str, GivenVariable]:
        """The variables that the model has, by their names."""
        return {
            name: GivenVariable(
                tuple(texts.values()), texts[variable.first], located(variable.at, self._folder)
            )
            for variable, name in self._variables.items()
            for texts in [_texts(variable)]
        }

    @property
    def waits(self) -> set[Effect]:
        """The waits of loops that the flows have: the model has all variables that the loops ask for."""
        return {
            each
            for fact in self._known
            for each in fact.effects
            if each.variables and self._variables.keys() >= set(each.variables)
        }

    # ------------------------------------------------------------------------------------ flows of callbacks

    def of(self, entity: Entity, role: str) -> Flow | None:
        """Return the flow of the callback of an entity; None: it depends on no variable and no response."""
        fact = entity.callbacks.get(role)
        if fact is None or fact not in self._called:
            return None
        flow = self._flow(fact)
        return without_marks(flow) if self._decides(flow) else None

    def received(self, entity: Entity, field: Deciding) -> Received | None:
        """Return the flows of a subscription's callback by a field of its message; None: it does not decide.

        Callbacks that depend on variables, too, stay open about the message.
        """
        fact = entity.callbacks.get("callback")
        if fact is None or fact not in self._called or self._decides(self._flow(fact)):
            return None
        tests = [each for each in tested(fact) if each.name == field.name]
        branches = []
        for value in field.texts:
            made = Branching(self._labels, {}, _texts, None, self._folder, (field, value))
            start = made.read(fact.body or [])
            branches.append((value, without_marks(simplified(made.graph, start, {}))))
        flows = [flow for _, flow in branches]
        if len(flows) == 1:  # all messages have one value: some branches are never taken
            flows.append(without_marks(self._flow(fact)))
        if all(each == flows[0] for each in flows) or max(len(flow.edges) for flow in flows) > MOST_EDGES:
            return None
        at = next((each.at for each in tests if each.at is not None), None)
        return Received(field.name, tuple(branches), "" if at is None else located(at, self._folder))

    def after(self, client: Entity) -> Flow | None:
        """Return the flow started by the responses of a client, or by the results of its goals."""
        do = "call" if client.kind == "clients" else "get_result"
        answers = self._answers.get((client, do))
        if answers is None or not any(map(self._decides, self._parts(client))):
            return None
        is_asked = do == "call" or passes(self._told(client, True), lambda label: label == _RESULT)
        flows = [self._flow(each) for each in answers.callbacks]
        return without_marks(either(flows, is_perhaps=not (answers.is_certain and is_asked and flows)))

    def told(self, client: Entity, accepted: bool) -> Flow | None:
        """Return the flow of an action client after a goal is accepted or rejected; None: of a service."""
        if (client, "send_goal") not in self._answers or not any(map(self._decides, self._parts(client))):
            return None
        return without_marks(self._told(client, accepted))

    def _told(self, client: Entity, accepted: bool) -> Flow:
        answers = self._answers[client, "send_goal"]
        flows = [self._flow(each, accepted) for each in answers.callbacks]
        return either(flows, is_perhaps=not (answers.is_certain and flows))

    def _parts(self, client: Entity) -> list[Flow]:
        """Return all flows that start with a response to a client."""
        found = []
        for do in ("call", "send_goal", "get_result"):
            for fact in self._answers[client, do].callbacks if (client, do) in self._answers else ():
                found += [
                    self._flow(fact, each) for each in ((True, False) if do == "send_goal" else (None,))
                ]
        return found

    @staticmethod
    def _decides(flow: Flow) -> bool:
        return bool(variables_of(flow)) or has_data(flow)

    def _flow(self, fact: CallbackFact, accepted: bool | None = None) -> Flow:
        if (fact, accepted) not in self._flows:
            responses = self._responses(fact)
            flow = self._built(fact, accepted, responses)
            if responses != Responses() and len(flow.edges) > MOST_EDGES:
                flow = self._built(fact, accepted, Responses())
            self._flows[fact, accepted] = flow
        return self._flows[fact, accepted]

    def _built(self, fact: CallbackFact, accepted: bool | None, responses: Responses) -> Flow:
        made = Branching(self._labels, self._variables, _texts, accepted, self._folder, None, responses)
        start = made.read(fact.body or [])
        values = {name: tuple(_texts(each).values()) for each, name in self._variables.items()}
        if responses == Responses():
            return simplified(made.graph, start, values)
        given = "" if responses.given is None else responses.given.name
        flow = simplified(*followed(made.graph, start, given), values)
        return decided(flow, values, responses.values())

    def _responses(self, fact: CallbackFact) -> Responses:
        """Return the fields of responses on which a callback depends, or that it gives."""
        if not self._fields:
            return Responses()
        calls: dict[Effect, Deciding] = {}
        started: Deciding | None = None
        for each in answers_tested(fact):
            client = None if each.call is None else each.call.entity
            name = "" if client is None else self._names.get(client, "")
            field = self._fields.get(of_service(name))
            if each.call is None or field is None or field.name != each.name:
                continue
            if not each.starts:
                calls[each.call] = field
            elif self._is_only(client):
                started = field
        entity = self._called.get(fact)
        is_server = entity is not None and entity.kind == "services"
        given = self._fields.get(of_service(self._names[entity])) if is_server and entity else None
        return Responses(calls, started, given) if len(calls) <= _MOST_CALLS else Responses(given=given)

    def _is_only(self, client: Entity | None) -> bool:
        """Return whether a node has no other client of the same service."""
        clients = [self._names[each] for each in self._names if each.kind == "clients"]
        return client is not None and clients.count(self._names[client]) == 1

    def _labels(self, effect: Effect) -> tuple[list[Label], bool] | None:
        """Return what an effect does, in order, and whether it is optional; None: nothing in the model."""
        if effect.do == "get_result" and effect.then is not None:
            return [_RESULT], False
        step = self._step(effect)
        return None if step is None else ([step, *acceptance_after(effect, step)], bool(step.times))

    # ------------------------------------------------------------------------------------- which are certain

    def _entities(self) -> dict[CallbackFact, Entity]:
        """Return the callbacks of entities in the model, if each belongs to one entity."""
        found: dict[CallbackFact, Entity] = {}
        several: set[CallbackFact] = set()
        roles = {"subscriptions": "callback", "services": "callback", "action_servers": "execute"}
        listed = [(each, roles[each.kind]) for each in self._names if each.kind in roles]
        listed += [(each, "callback") for each in self._fact.of("timers") if each.is_enabled]
        for entity, role in listed:
            fact = entity.callbacks.get(role)
            if fact is None:
                continue
            is_kept = entity.kind == "timers" or not is_open(entity.type)
            if not is_kept or fact in found or any(entity.details.get(each) for each in _ONCE):
                several.add(fact)
            found[fact] = entity
        shared = [self._names[each] for each in self._names if each.kind in ("services", "action_servers")]
        return {
            fact: entity
            for fact, entity in found.items()
            if fact not in several
            and self._is_followed(fact)
            and (entity.kind not in ("services", "action_servers") or shared.count(self._names[entity]) == 1)
        }

    def _answers_of(self, client: Entity, do: str) -> _Answers:
        """Return the callbacks that responses to a client start."""
        effects = [
            effect
            for fact in self._fact.callbacks
            for effect in fact.effects
            if effect.entity is client and effect.do == do
        ]
        if do == "call":
            effects = [each for each in effects if (step := self._step(each)) is None or step.verb == "send"]
        callbacks = [each.then for each in effects if each.then is not None]
        return _Answers(tuple(dict.fromkeys(callbacks)), len(callbacks) == len(effects))

    def _is_followed(self, fact: CallbackFact) -> bool:
        return fact.body is not None and not fact.is_apart and not self._is_open(fact)

    def _followed_once(self) -> set[CallbackFact]:
        """Return the callbacks with a flow that one entity, or the responses of one client, begin."""
        clients = [self._names[client] for client, _ in self._answers]
        answered = [
            fact
            for (client, _), answers in self._answers.items()
            if clients.count(self._names[client]) == (1 if client.kind == "clients" else 2)
            for fact in answers.callbacks
        ]
        return {
            fact
            for fact in (*self._called, *answered)
            if self._is_followed(fact) and answered.count(fact) + (fact in self._called) == 1
        }

    def _certain(self) -> dict[Variable, str]:
        """Return the variables that only callbacks of the model set."""
        loose: set[Variable] = set()
        for fact in self._fact.callbacks:
            if fact not in self._known:
                loose |= variables_set(fact.body or [])
        names: dict[Variable, str] = {}
        for variable in self._fact.variables:
            if variable not in loose:
                names[variable] = _free(re.sub(r"\W+", "_", variable.name), names.values())
        return names

    def _is_settled(self) -> bool:
        """Omit variables of callbacks that are too large, and those without influence."""
        flows = [self._flow(fact) for fact in self._called]
        for client in {client for client, _ in self._answers}:
            flows += self._parts(client)
        large = {each for flow in flows if len(flow.edges) > MOST_EDGES for each in variables_of(flow)}
        asked = {each for flow in flows for each in variables_of(flow, Ask)} - large
        left = {variable: name for variable, name in self._variables.items() if name in asked}
        is_settled = len(left) == len(self._variables)
        self._variables = left
        return is_settled


def tested(fact: CallbackFact) -> list[TestOfField]:
    """Return the tests of fields of the message that a callback receives, in the order of the code."""
    tests = [each for each in conditions(fact.body or []) if isinstance(each, TestOfField)]
    return sorted(tests, key=lambda each: 0 if each.at is None else each.at.line)


def answers_tested(fact: CallbackFact) -> list[Answered]:
    """Return the tests of fields of responses in a callback."""
    return [each for each in conditions(fact.body or []) if isinstance(each, Answered)]


def _texts(variable: Variable) -> dict[Known, str]:
    """Return the values of a variable as a model names them."""
    found: dict[Known, str] = {}
    for value in variable.values:
        text = repr(value[2]) if value[0] == "const" else str(shown(value))
        found[value] = _free(text[:60], found.values())
    return found


def _free(wanted: str, used: Iterable[str]) -> str:
    names, found, number = set(used), wanted, 2
    while found in names:
        found, number = f"{wanted}_{number}", number + 1
    return found
