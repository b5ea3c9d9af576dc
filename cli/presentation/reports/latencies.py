"""Prints the results of `dineros latency`, as text and as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.outputs import write_page
from dineros.cli.presentation.traces import witness_picture

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from dineros.analysis.bounds.answers import Bounds
    from dineros.analysis.latencies.depths import Depth
    from dineros.analysis.latencies.results import Everything, Latency
    from dineros.analysis.witnesses.witness import Witness
    from dineros.metamodel import sym

OVERFLOWS = {True: ", can overflow", False: "", None: "; it is unknown whether it can overflow"}
TICKS = {True: "can lose ticks", False: "loses no tick", None: "it is unknown whether it loses ticks"}


def write_latency_page(
    everything: Everything,
    bounds: Bounds,
    model: sym.SystemModel,
    output: Path,
    source: Path,
    settings: Sequence[str],
    chains: Sequence[str],
    worst: tuple[str, Witness] | None,
    notes: Sequence[str],
) -> None:
    """Write a page, atomically; a line reports a missing picture.

    Parameters
    ----------
    everything, bounds
        Response times, and known shares of threads.
    model, source, settings
        The model, its file, and how it was changed.
    chains
        What is known of the chain that was asked for, in words.
    worst
        What takes longest, in words, and its run.
    notes
        What the answers rest on.
    """
    from dineros.analysis.latencies.paths import callback_pages
    from dineros.metamodel.elements import label, node_net_of
    from dineros.metamodel.times.given import duration_of, period_of
    from dineros.views.reports.latency_report import CallbackRow, LatencyContent, latency_page

    rows = []
    for page in callback_pages(model):
        if page.id not in everything.callbacks:
            continue
        response, node = everything.callbacks[page.id], node_net_of(page)
        rate, share = bounds.runs_per_second(page), bounds.share_of_thread(page)
        duration, period = duration_of(page), period_of(page)
        assert node is not None, "only executors run callbacks"
        rows.append(
            CallbackRow(
                label(page),
                label(node),
                f"{period:g} s" if period is not None else f"{float(1 / rate):g} s" if rate else "open",
                "open" if duration is None else _interval(duration.earliest, duration.latest),
                span(response),
                response.reason,
                None if response.greatest is None else float(response.greatest.value),
                None if share is None else float(share),
            )
        )
    view = None if worst is None else witness_picture(worst[1], str(source), worst[0])
    content = LatencyContent(
        title=model.name or model.id,
        source=str(source),
        settings=tuple(settings),
        chains=chains,
        rows=rows,
        readers=[
            (name, longest, "yes" if overflows else "no" if overflows is False else "not known")
            for name, (longest, overflows) in everything.readers.items()
        ],
        timers=[(name, TICKS[loses]) for name, loses in everything.timers.items()],
        worst="" if worst is None else worst[0],
        steps=[] if worst is None else [step.shown for step in worst[1].steps],
        view=view,
        notes=notes,
    )
    write_page(output, *latency_page(content))


def _interval(earliest: float | None, latest: float | None) -> str:
    first = earliest or 0.0
    return f"at least {first:g} s" if latest is None else f"{first:g} to {latest:g} s"


def lines_of_depths(found: Mapping[str, Depth]) -> list[str]:
    """Return the needed depths, a line for each reader."""
    lines = []
    for name, each in found.items():
        if each.least is None:
            lines.append(f"reader {name}: no sufficient depth is known: {each.reason}")
        else:
            enough = "" if each.least <= each.depth else ", loses messages"
            lines.append(f"reader {name}: least depth {each.least}; it has {each.depth}{enough}")
    return lines


def lines_of_all(found: Everything) -> list[str]:
    """Return the results for all callbacks, histories and timers, a line each."""
    lines = []
    for name, each in found.callbacks.items():
        starves = ", can wait without end" if found.starved.get(name) else ""
        lines.append(f"callback {name}: {span(each)}{starves}")
        if each.reason:
            lines.append(f"    no bound: {each.reason}")
    for name, (longest, can_overflow) in found.readers.items():
        lines.append(f"reader {name}: at most {longest} waiting{OVERFLOWS[can_overflow]}")
        lines += _why(found, name, can_overflow)
    for name, loses in found.timers.items():
        lines.append(f"timer {name}: {TICKS[loses]}")
        lines += _why(found, name, loses)
    return lines


def left_out(model: sym.SystemModel, found: Everything) -> list[str]:
    """Return a note about the callbacks of which no response time is computed; none if there are none."""
    from dineros.analysis.latencies.paths import callback_pages

    pages = [page for page in callback_pages(model) if page.id not in found.callbacks]
    names = ", ".join(f"{page.id} ({page.kind})" for page in pages)
    return [f"response times are not computed for {names}"] if pages else []


def _why(found: Everything, name: str, answer: bool | None) -> list[str]:
    return [f"    open: {found.reasons[name]}"] if answer is None and name in found.reasons else []


def span(found: Latency) -> str:
    """Return bounds in words; a bound that is only approached is marked."""
    if found.least is None:
        return "never ends" if not found.reason else "open"
    least = f"{'more than ' if not found.least.is_reached else ''}{float(found.least.value):g}"
    if found.greatest is None:
        return f"at least {least} s"
    greatest = f"{'less than ' if not found.greatest.is_reached else ''}{float(found.greatest.value):g}"
    if not found.is_exact:
        return f"at least {least} s, at most {greatest} s"
    return f"{least} s" if least == greatest else f"{least} to {greatest} s"
