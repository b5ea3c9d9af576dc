"""Converts effects of callbacks in code to steps of a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from dineros.observation.importing.assuming import Taken
from dineros.observation.importing.flows.goals import acceptance_after, waits_for_goal
from dineros.observation.importing.flows.labels import Deciding, Step
from dineros.sources.facts import LATER, TRANSFORM, CallbackFact, Effect, Entity
from dineros.sources.places import located

_TIMES = {"always": "", "conditional": "?", "in a loop": "*"}
_WAITS = ("blocks", "await", "spin-until", "polled", "waits for")
"""Prefixes of effects that wait for a response."""

USUAL_TIMEOUT = 1.0
"""Seconds that a callback waits for a response if its time-out is unknown."""


class Behaviour:
    """Converts effects to steps.

    Parameters
    ----------
    names : mapping of Entity to str
        Full names of the entities that the model has.
    taken : Taken
        Gets the omitted effects.
    folder : str
        The folder of the files.
    own : iterable of Entity
        All entities of the node, including those that the model omits.
    groups : mapping of Entity to str
        Callback groups of clients that have another one than the first client of their service; empty: the
        default group.
    deciding : mapping of str to Deciding
        Topics with a field on which callbacks depend.
    """

    def __init__(
        self,
        names: Mapping[Entity, str],
        taken: Taken,
        folder: str = "",
        own: Iterable[Entity] = (),
        groups: Mapping[Entity, str] | None = None,
        deciding: Mapping[str, Deciding] | None = None,
    ) -> None:
        self._deciding = deciding or {}
        self._groups = groups or {}
        self._names = names
        self._own = set(own)
        self._folder = folder
        self._taken = taken
        self.modelled: set[Effect] = set()
        """Waits that the model has by variables."""

    def is_open(self, fact: CallbackFact) -> bool:
        """Return whether a callback may take any steps."""
        return fact.is_open or any(
            each.entity is None and self._verb(each) is not None for each in fact.effects
        )

    def steps(self, fact: CallbackFact) -> tuple[Step, ...] | None:
        """Return the steps of a callback, in order; None: any steps, if the code was not followed."""
        if fact.is_open:
            return None
        found: list[Step] = []
        if fact.lacks == LATER and not any(each.do == "respond" for each in fact.effects):
            words = "returns without a response, which other code sends"
            at = located(fact.at, self._folder)
            self._taken.lack(f"{at}: {fact.name} {words}; in the model, it responds when it ends")
        for effect in fact.effects:
            at = located(effect.at, self._folder)
            is_short = effect.what == TRANSFORM and not effect.is_repeated  # it ends by itself
            is_endless = effect.do == "wait_for_message" and effect.how == "without time-out"
            is_wait = effect.do == "wait" and not is_short and effect not in self.modelled
            if is_wait or is_endless:
                self._taken.lack(
                    f"{at}: waits for {effect.what} ({effect.how}); in the model it continues at once"
                )
            if effect.do == "loop" and effect.how and (effect.pace is None or fact.kind != "thread"):
                words = f"may loop forever ({effect.what}): {effect.how}"
                self._taken.lack(f"{at}: {words}; in the model, the loop ends")
            if effect.do == "respond":
                words = "gets its response here; in the model, when its callback ends"
                self._taken.add(f"{at}: a request of {effect.what} {words}")
            if self._verb(effect) is None:
                continue
            if effect.entity is None:
                return None
            step = self.step(effect)
            if step is not None:
                found += [step, *acceptance_after(effect, step)]
            elif effect.entity not in self._own:  # otherwise it is reported where the entity is omitted
                self._taken.lack(f"{at}: uses {effect.what} of another node; omitted in the model")
        return tuple(found)

    def step(self, effect: Effect) -> Step | None:
        """Return the step of an effect; None: it has none, or the model does not have its entity."""
        verb, at = self._verb(effect), located(effect.at, self._folder)
        if verb is None or effect.entity is None or effect.entity not in self._names:
            return None
        timeout = self._timeout(effect, at) if verb == "call" else None
        name, group = self._names[effect.entity], self._groups.get(effect.entity)
        step = Step(verb, name, _TIMES[effect.when], at, timeout, group, self._sends(effect, name))
        is_one_of_several = effect.entity.details.get("instances") and step.times == ""
        return replace(step, times="?") if is_one_of_several else step

    def _sends(self, effect: Effect, name: str) -> tuple[tuple[str, str], ...]:
        deciding = self._deciding.get(name) if effect.do == "publish" else None
        if deciding is None or deciding.name not in effect.sends:
            return ()
        return ((deciding.name, deciding.known[effect.sends[deciding.name]]),)

    def in_branch(self, effect: Effect) -> Step | None:
        """Return the step of an effect in its branch, where it happens once, possibly one of several."""
        step = self.step(effect)
        if step is None or effect.entity is None:
            return None
        return replace(step, times="?" if effect.entity.details.get("instances") else "")

    def _timeout(self, effect: Effect, at: str) -> float | None:
        """Return the time-out of a callback for a response; without it, a deadlock would be reported."""
        if effect.timeout is not None or "open" not in effect.how:
            return effect.timeout
        self._taken.add(f"{at}: {effect.what} is waited for with an unknown time-out; 1 s is assumed")
        return USUAL_TIMEOUT

    @staticmethod
    def _verb(effect: Effect) -> str | None:
        if effect.do == "publish":
            return "publish"
        if effect.do == "call":
            return "call" if effect.how.startswith(_WAITS) else "send"
        if effect.do == "get_result":
            return "result" if waits_for_goal(effect) else None
        return {"send_goal": "goal", "cancel_goal": "cancel"}.get(effect.do)

    @staticmethod
    def gives_back(fact: CallbackFact) -> bool:
        """Return whether a callback releases its thread while it waits: it awaits, spins, or has its own."""
        if fact.is_apart:
            return True
        waits = [
            effect.how
            for effect in fact.effects
            if (effect.do == "call" and effect.how.startswith(_WAITS)) or waits_for_goal(effect)
        ]
        return bool(waits) and all(how.startswith(("await", "spin-until")) for how in waits)

    def after(self, client: Entity, callbacks: Iterable[CallbackFact]) -> tuple[Step, ...] | None:
        """Return the done callbacks of a client's responses; of an action, those of goal and result."""
        found: list[Step] = []
        for fact in callbacks:
            for effect in fact.effects:
                if effect.entity is not client or effect.then is None:
                    continue
                if effect.do in ("call", "send_goal", "get_result"):
                    steps = self.steps(effect.then)
                    if steps is None:
                        return None
                    steps = tuple(step for step in steps if not self._is_in_answer(step))
                    is_certain = effect.do == "call" and not found
                    found += [
                        step if is_certain or step.times else replace(step, times="?") for step in steps
                    ]
        return tuple(dict.fromkeys(found))

    def _is_in_answer(self, step: Step) -> bool:
        """Return whether a done callback waits for a goal: the callback of results cannot wait for itself."""
        if step.verb not in ("accepted", "result"):
            return False
        self._taken.lack(f"{step.at}: waits for a goal of {step.name}; in the model it continues at once")
        return True
