"""What a handler left and returned, checked: the data that continues, and data of single output places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.runtime.firing.flights import Flight
from dineros.runtime.firing.handlers import Given
from dineros.runtime.nets.engine import Engine, Tokens
from dineros.runtime.nets.ports import Data

GivenData = dict[int, list[Data]]
"""For some output places, the data of all tokens."""


class WrongReturnError(DinerosError):
    """A handler returned something that is not data for the output places."""


def checked_result(engine: Engine, flight: Flight, result: object) -> tuple[Data, GivenData | None]:
    """Return what continues after a handler: the data, and that of single places where it says so.

    Parameters
    ----------
    engine, flight : Engine, Flight
        What fires, with what its handlers have left and given so far.
    result : object
        What the last of them returned.

    Raises
    ------
    DinerosError
        It is no such thing, or does not fit the token type.
    """
    transition, taken = flight.transition, flight.taken
    checker = engine.result_checker(transition)
    data = checker.complete(flight.firing.data, flight.data)
    if result is None:
        return data, flight.given
    if isinstance(result, Given):
        return data, _given(engine, transition, taken, result, data)
    if isinstance(result, Mapping):
        return checker.complete(result, data), None
    raise WrongReturnError(
        f"returned an object of class {type(result).__name__}",
        hint="return None, a mapping of fields, or firing.give(...)",
    )


def missing_data(engine: Engine, transition: int, given: GivenData | None) -> WrongReturnError | None:
    """Return what is wrong where handlers gave no data to a place whose type only they can make."""
    structure = engine.structure
    for place in engine.demands[transition]:
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
                f"gives tokens to {name!r}", hint=near_matches(str(name), list(outputs)) or "it is not output"
            )
        place, weight = outputs[name]
        several: Sequence[object] = some if isinstance(some, (list, tuple)) else [some] * weight
        if len(several) != weight:
            raise WrongReturnError(f"gives {len(several)} tokens to {name!r}, whose arc has weight {weight}")
        bases = [token.data for token in own.get(place, ())][:weight]
        fits = engine.is_result(transition, place)
        bases += [data if fits else engine.data_for(transition, taken, place)] * (weight - len(bases))
        complete = engine.checkers[place].complete
        given[place] = [complete(each, base) for each, base in zip(several, bases, strict=True)]
    return given
