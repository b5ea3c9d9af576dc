"""Prints a state space: its figures, the run by which places grow, and the rest, as text and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from dineros.cli.analysing import say_witness
from dineros.cli.console import say, say_figures, say_json
from dineros.cli.presentation.answers import assumes_field, say_assumes, say_times, times_fields
from dineros.cli.presentation.evidence import say_confirmation

if TYPE_CHECKING:
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.portfolio.count import StateSpace

_OF_THE_REDUCED_NET = ("places", "transitions")
_OF_THE_REST = (
    "states",
    "arcs",
    "deadlocks",
    "max_tokens_in_place",
    "max_tokens_in_marking",
    "engine",
    "complete",
    "reason",
)


def say_state_space(
    space: StateSpace,
    subject: Subject,
    asked: Mapping[str, Any],
    confirmed: Sequence[Confirmation | None],
    as_json: bool,
) -> None:
    """Print a state space.

    Parameters
    ----------
    asked : mapping
        The question, for JSON: the model, its variant, and whether it was ``reduced``.
    confirmed : sequence
        The results of other engines that counted again; empty if none was asked.
    """
    from dineros.analysis.model.assumptions import of_source
    from dineros.analysis.model.times import left_out_times
    from dineros.analysis.witnesses.witness import pumping_witness

    times, assumes = left_out_times(subject.model), of_source(subject.model)
    figures = {**asked, **space.to_dict()}
    if asked["reduced"]:
        figures["reduced_states"] = space.reduced_states
    pumping = None if space.pumping is None else pumping_witness(subject, space.pumping)
    rest: dict[str, Any] = {}
    if space.rest is not None:
        told = space.rest.to_dict()
        rest = {"without": list(space.without), **{name: told[name] for name in _OF_THE_REST}}
    confirmation = next(iter(confirmed), None)
    if as_json:
        more: dict[str, Any] = {}
        if confirmed:
            more["confirmation"] = confirmation.to_dict() if confirmation else None
        if pumping is not None:
            more["pumping"] = pumping.to_dict()
        more |= times_fields(times, False)
        say_json({**figures, **more, **({"rest": rest} if rest else {}), **assumes_field(assumes)})
    else:
        notes = dict.fromkeys(_OF_THE_REDUCED_NET if asked["reduced"] else (), " (of the reduced net)")
        say_figures(figures, notes=notes)
        if pumping is not None:
            say_witness(pumping)
        if rest:
            say(f"without places that no transition takes from ({', '.join(rest.pop('without'))}):")
        say_figures(rest, indent="  ")
        if times is not None:
            say_times(times, times.of_counts)
        say_assumes(assumes)
    if confirmation is not None:
        say_confirmation(confirmation, as_json)
