"""``dineros run --simulate --times``: quantiles of times in a simulated run."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.models import load_valid_system
from dineros.cli.outputs import write_page
from dineros.cli.presentation.traces import witness_picture
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.timed_runs.simulating import Simulated, SimulatedTimes
    from dineros.metamodel import sym

SHOWN = 150
"""Limit of the firings that a page shows."""
SECONDS = 100.0
"""Default length of a simulation, in simulated time."""


def simulate_times_of(
    model: Path,
    settings: Sequence[str],
    seconds: float | None,
    seed: int | None,
    report: Path | None,
    as_json: bool,
) -> int:
    """Simulate a model with its times, and print the measurements.

    Raises
    ------
    DinerosError
        The model is not valid, has no times, or its time stops.
    """
    from dineros.analysis.timed_runs.simulating import simulate_times

    system = load_valid_system(model, settings)
    seed = random.SystemRandom().getrandbits(32) if seed is None else seed
    kept = 0 if report is None else SHOWN
    found = simulate_times(system, SECONDS if seconds is None else seconds, seed, kept)
    if report is not None:
        _write_page(report, model, system, found, seed)
    if as_json:
        say_json(_report(model, found, seed))
        return 0
    for each in found.missing:
        warn(f"{model}: {each}: a time is drawn that the model does not give")
    for times in found.responses:
        say(f"callback {times.first} responds: {_summary(times)}")
    for times in found.chains:
        say(f"{times.first} to {times.last}: {_summary(times)}")
    for line in _losses(found):
        say(line)
    summarise(f"{model}: simulated {found.seconds:g} s, seed {seed}: {counted(found.firings, 'firing')}")
    return 0


def _write_page(report: Path, model: Path, system: sym.SystemModel, found: Simulated, seed: int) -> None:
    """Write histograms, and the first part of the run on a time axis."""
    from dineros.analysis.timed_runs.simulating import histogram
    from dineros.observation.measuring.samples import duration_text
    from dineros.views.reports.simulation_report import Histogram, SimulationContent, simulation_page

    shown = []
    for times in (*found.responses, *found.chains):
        bars = histogram(times.values)
        is_response = times.first == times.last
        name = f"callback {times.first} responds" if is_response else f"{times.first} to {times.last}"
        ends = duration_text(bars["least"]), duration_text(bars["greatest"])
        shown.append(Histogram(name, _summary(times), *ends, bars["counts"]))
    view = None
    if found.run is not None:
        view = witness_picture(found.run, str(model), "simulated run")
        view["cause"] = None  # the run shows nothing that is wrong
    content = SimulationContent(
        title=str(system.name or system.id),
        source=str(model),
        what=f"{found.seconds:g} s, seed {seed}, {counted(found.firings, 'firing')}",
        histograms=shown,
        notes=[*_losses(found), *found.missing],
        view=view,
    )
    write_page(report, *simulation_page(content))


def _losses(found: Simulated) -> list[str]:
    return [f"reader {place} lost {counted(count, 'message')}" for place, count in sorted(found.lost.items())]


def _summary(times: SimulatedTimes) -> str:
    from dineros.observation.measuring.samples import Samples

    return str(Samples(times.values).summary())


def _report(model: Path, found: Simulated, seed: int) -> dict[str, Any]:
    from dineros.analysis.timed_runs.simulating import histogram
    from dineros.observation.measuring.samples import Samples

    def shown(times: SimulatedTimes) -> dict[str, Any]:
        summary = Samples(times.values).summary().to_dict()
        return {"from": times.first, "to": times.last, **summary, "histogram": histogram(times.values)}

    return {
        "model": str(model),
        "seconds": found.seconds,
        "seed": seed,
        "firings": found.firings,
        "callbacks": {times.first: shown(times) for times in found.responses},
        "chains": [shown(times) for times in found.chains],
        "lost": dict(sorted(found.lost.items())),
        "missing": found.missing,
    }
