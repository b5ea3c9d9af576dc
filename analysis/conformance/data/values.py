"""Checks the data of recorded tokens against the guards and assignments of the model.

The rest of a replay counts tokens. This module tracks the data on places that occur in guards, or whose
fields are assigned or copied. Within a node, records are in order, so the tokens on a place are known when a
transition fires.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dineros.analysis.conformance.data.decisions import Decision, Decisions
from dineros.analysis.conformance.data.fitting import held, misfit
from dineros.analysis.conformance.reasons import step_words
from dineros.analysis.conformance.refusals import Fault
from dineros.analysis.conformance.verdict import Deviation
from dineros.metamodel.guards.conditions import Condition, comparisons
from dineros.metamodel.guards.deciding import fulfils, value_text
from dineros.metamodel.records import Checkpoint, Data, Drop, Fire, Record, Start, StoredToken
from dineros.metamodel.token_data import FieldType


class Values:
    """The data of tokens on places that matter for guards, according to the records.

    Attributes
    ----------
    unclear : list of Deviation
        Steps whose data is not in the traces.
    """

    def __init__(self, decisions: Decisions) -> None:
        self._decisions = decisions
        self._tokens: dict[str, dict[int, Data]] = {place: {} for place in decisions.fields}
        self.unclear: list[Deviation] = []
        self._started: set[str | None] = set()

    def fault(self, record: Record) -> Fault | None:
        """Return what is wrong with the data of a step; None: nothing is known to be wrong."""
        if self._decisions.typed:
            arriving = ((place, token.data) for place, token in _arriving(record))
            for place, data in held(record) if isinstance(record, Start) else arriving:
                if (wrong := misfit(place, data, self._decisions.typed.get(place, {}))) is not None:
                    return Fault(wrong)
        if isinstance(record, Start):
            return self._misplaced(record)
        if isinstance(record, Fire) and (decision := self._decisions.of.get(record.transition)) is not None:
            return self._forbidden(record, decision) or self._misassigned(record, decision)
        return None

    def happen(self, record: Record) -> None:
        """Apply a step that is allowed."""
        if isinstance(record, Start):
            self._started.add(record.node)
            self._begin(record)
            return
        for place, id in self._leaving(record):
            self._tokens[place].pop(id, None)
        for place, token in _arriving(record):
            if place in self._tokens:
                self._tokens[place][token.id] = token.data

    def _begin(self, record: Start) -> None:
        apart = record.apart.get("marking", {}) if isinstance(record, Checkpoint) else {}
        for place, tokens in record.marking.items():
            if place in self._tokens:
                known = self._tokens[place]
                self._tokens[place] = {
                    id: known.get(id, {}) if place in apart else data for id, data in tokens
                }

    def _leaving(self, record: Record) -> list[tuple[str, int]]:
        if isinstance(record, Fire):
            found = [(place, id) for place, ids in record.taken.items() for id in ids]
        else:
            place, token = getattr(record, "place", None), getattr(record, "token", None)
            leaves = record.declared.token == "leaves"
            if isinstance(record, Drop):
                leaves = record.queue != "request" and record.change.get(place or "", 0) < 0
            found = [(place, token)] if leaves and place is not None and token is not None else []
            unheeded = getattr(record, "unheeded", None)
            if unheeded is not None:
                found += [(each, unheeded) for each in getattr(record, "change", {}) if each != place]
        return [each for each in found if each[0] in self._tokens]

    def _misplaced(self, record: Start) -> Fault | None:
        """Return the place whose tokens have other data than in the model when the node first starts."""
        is_late = isinstance(record, Checkpoint) and record.sequence > 1  # older parts were deleted
        if is_late or record.resumed or record.node in self._started:
            return None
        apart = record.apart.get("marking", {}) if isinstance(record, Checkpoint) else {}
        for place, tokens in record.marking.items():
            fields = [
                field
                for field in self._decisions.fields.get(place, {}).values()
                if field.kind in ("boolean", "integer") and all(field.name in each.data for each in tokens)
            ]
            if place in apart:
                continue
            found = sorted(_texts(fields, (each.data for each in tokens)))
            expected = sorted(_texts(fields, self._decisions.initial.get(place, [])))
            if found != expected and len(found) == len(expected):  # another number is found by the replay
                pair = next(pair for pair in zip(found, expected, strict=True) if pair[0] != pair[1])
                parts = [each for each in zip(*pair, strict=True) if each[0] != each[1]]
                other, own = (", ".join(each) for each in zip(*parts, strict=True))
                return Fault(f"{place} holds a token with {other}, in the model {own}")
        return None

    def _forbidden(self, record: Fire, decision: Decision) -> Fault | None:
        """Return why a guard forbids a firing."""
        for place, condition in decision.takes.items():
            data = self._taken(record, place)
            if not self._is_known(data, condition):
                self._note(record, f"the data of the token that it takes from {place} is unknown")
            elif not fulfils(condition, data):
                return Fault(
                    f"its guard does not allow the token of {place}: {self._text(place, data, condition)}"
                )
        for place, condition in decision.reads.items():
            held = self._tokens[place].values()
            known = [data for data in held if self._is_known(data, condition)]
            if any(fulfils(condition, data) for data in known):
                continue
            if len(known) < len(held):
                self._note(record, f"the data of the tokens of {place} is unknown")
                continue
            texts = "; ".join(self._text(place, data, condition) for data in known) or "no token"
            return Fault(f"its guard allows no token of {place}, which it reads: {texts}")
        return None

    def _misassigned(self, record: Fire, decision: Decision) -> Fault | None:
        """Return the field of a token whose value differs from the assignment."""
        for place, given in decision.assigns.items():
            for name, value in given.items():
                expected = self._expected(record, decision, value) if isinstance(value, tuple) else [value]
                for token in record.made.get(place, ()):
                    if None in expected or name not in token.data:
                        self._note(record, f"the expected value of {place}.{name} is unknown")
                    elif token.data[name] not in expected:
                        field = self._decisions.fields[place][name]
                        texts = " or ".join(dict.fromkeys(value_text(each, field) for each in expected))
                        found = value_text(token.data[name], field)
                        return Fault(
                            f"{place}.{name} is {found}, but the transition assigns {texts or 'nothing'}"
                        )
        return None

    def _expected(self, record: Fire, decision: Decision, source: tuple[str, str]) -> list[Any]:
        """Return the possible values of a copied field; None among them: the value is unknown."""
        place, name = source
        if place in record.taken:
            return [self._taken(record, place).get(name)]
        asked = decision.reads.get(place)
        return [
            data.get(name)
            for data in self._tokens[place].values()
            if asked is None or not self._is_known(data, asked) or fulfils(asked, data)
        ]

    def _taken(self, record: Fire, place: str) -> Data:
        """Return the data of the only token that a step takes from a place; empty: it is unknown."""
        ids = record.taken.get(place, [])
        return self._tokens[place].get(ids[0], {}) if len(ids) == 1 else {}

    @staticmethod
    def _is_known(data: Data, condition: Condition) -> bool:
        return all(isinstance(data.get(each.field.field), int) for each in comparisons(condition))

    def _text(self, place: str, data: Data, condition: Condition) -> str:
        fields = self._decisions.fields[place]
        names: Iterable[str] = dict.fromkeys(each.field.field for each in comparisons(condition))
        return ", ".join(f"{name}={value_text(data[name], fields[name])}" for name in names)

    def _note(self, record: Fire, reason: str) -> None:
        self.unclear.append(Deviation(record, step_words(record), reason))


def _texts(fields: Iterable[FieldType], tokens: Iterable[Data]) -> list[tuple[str, ...]]:
    """Return the values of some fields of each token, as guards write them."""
    return [tuple(f"{f.name}={value_text(data[f.name], f)}" for f in fields) for data in tokens]


def _arriving(record: Record) -> list[tuple[str, StoredToken]]:
    """Return the tokens that a record puts on places, with their places."""
    if isinstance(record, Fire):
        return [(place, token) for place, tokens in record.made.items() for token in tokens]
    place, token = getattr(record, "place", None), getattr(record, "token", None)
    arrives = record.declared.token in ("arrives", "may arrive")
    data = getattr(record, "data", None) or {}
    return [(place, StoredToken(token, data))] if arrives and place and token is not None else []
