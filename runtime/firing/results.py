"""Checks the data and the result of a handler: the data passed on, and data for single output places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.runtime.firing.flights import Flight
from dineros.runtime.firing.handlers import Given
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.ports import Data

GivenData = dict[int, list[Data]]
"""Data of all tokens for some output places."""


class WrongReturnError(DinerosError):
    """A handler returned something that is not data for the output places."""


def checked_result(engine: Engine, flight: Flight, result: object) -> tuple[Data, GivenData | None]:
    """Return the data passed on after a handler, and the data for single places, if it gave any.

    Parameters
    ----------
    engine, flight : Engine, Flight
        The net, and the firing with the data of its handlers so far.
    result : object
        The result of the last handler.

    Raises
    ------
    DinerosError
        The result is of another kind, does not fit the token type, or differs from what the transition
        assigns.
    """
    transition, taken = flight.transition, flight.taken
    checker = engine.passing.result_checker(transition)
    data = checker.complete(flight.firing.data, flight.data)
    if result is None:
        return _as_assigned(engine, flight, data, flight.given)
    if isinstance(result, Given):
        return _as_assigned(engine, flight, data, _given(engine, transition, taken, result, data))
    if isinstance(result, Mapping):
        return _as_assigned(engine, flight, checker.complete(result, data), None)
    raise WrongReturnError(
        f"returned an object of class {type(result).__name__}",
        hint="return None, a mapping of fields, or firing.give(...)",
    )


def _as_assigned(
    engine: Engine, flight: Flight, data: Data, given: GivenData | None
) -> tuple[Data, GivenData | None]:
    """Refuse data that differs from the assigned values; data that the handlers got counts as unchanged."""
    transition = flight.transition
    assigns = engine.structure.decisions[transition].assigns
    shown = engine.passing.passed_on(transition, flight.taken) if assigns else data
    for place, _ in assigns:
        if engine.passing.is_result(transition, place) and (given is None or place not in given):
            assigned = engine.passing.assigned(transition, flight.taken, place)
            changed = {name: data[name] for name in assigned if data[name] != shown[name]}
            _require_assigned(engine, place, changed, assigned)
    return data, given


def _require_assigned(
    engine: Engine, place: int, data: Mapping[str, object], assigned: Mapping[str, object]
) -> None:
    for name, value in assigned.items():
        if data.get(name, value) != value:
            raise WrongReturnError(
                f"gives {engine.structure.place_names[place]}.{name} the value {data[name]}, but the "
                f"transition assigns {value}",
                hint=f"leave {name} out",
            )


def missing_data(engine: Engine, transition: int, given: GivenData | None) -> WrongReturnError | None:
    """Return an error if handlers gave no data to a place whose token type only they can make."""
    structure = engine.structure
    for place in engine.passing.demands[transition]:
        if given is None or place not in given:
            name = structure.place_names[place]
            return WrongReturnError(
                f"gives no {structure.types[place].name} to {name!r}, which the transition does not take",
                hint=f"return firing.give({{{name!r}: {{...}}}})",
            )
    return None


def _given(engine: Engine, transition: int, taken: Tokens, result: Given, data: Data) -> GivenData:
    structure, own = engine.structure, dict(taken)
    outputs = {}
    for place, weight in structure.outputs[transition]:
        outputs[structure.place_names[place]] = outputs[structure.places[place]] = (place, weight)
    given: GivenData = {}
    for name, some in result.places.items():
        if name not in outputs:
            raise WrongReturnError(
                f"gives tokens to {name!r}",
                hint=near_matches(str(name), list(outputs)) or "it is not an output place",
            )
        place, weight = outputs[name]
        several: Sequence[object] = some if isinstance(some, (list, tuple)) else [some] * weight
        if len(several) != weight:
            raise WrongReturnError(f"gives {len(several)} tokens to {name!r}, whose arc has weight {weight}")
        bases = [token.data for token in own.get(place, ())][:weight]
        fits = engine.passing.is_result(transition, place)
        bases += [data if fits else engine.passing.data_for(transition, taken, place)] * (weight - len(bases))
        complete = engine.passing.checkers[place].complete
        assigned = engine.passing.assigned(transition, taken, place)
        given[place] = [
            complete(each, {**base, **assigned} if assigned else base)
            for each, base in zip(several, bases, strict=True)
        ]
        for each in given[place]:
            _require_assigned(engine, place, each, assigned)
    return given
