"""A trace as a table: a row for each step."""

from __future__ import annotations

import csv
import io
import json

from dineros.views.traces.building import TraceBuilder

_COLUMNS = (
    "step",
    "time",
    "node",
    "event",
    "transition",
    "text",
    "change",
    "signals",
    "details",
    "loop",
    "earliest",
    "latest",
)


def export(builder: TraceBuilder) -> bytes:
    """Return a trace as CSV (RFC 4180, but lines end as on Unix).

    ``time`` is in seconds since the epoch, or from the start of a schedule; ``change``, ``signals`` (all
    values after the step) and ``details`` are JSON objects; ``loop`` is whether the step repeats forever.
    In a schedule, the step can happen from ``earliest`` to ``latest``, which is empty if it can be any time
    later.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    lanes = builder.lanes.all
    signals = {lane.id: lane.setting(lane.initial) for lane in lanes if lane.kind == "signal"}
    for number, step in enumerate(builder.steps):
        for lane, letter, *values in step.marks:
            if letter == "v":
                signals[lanes[lane].id] = lanes[lane].setting(values[0])
        writer.writerow(
            [
                number + 1,
                "" if step.time is None else repr(step.time),
                step.node or "",
                step.event,
                step.transition or "",
                step.text,
                json.dumps(step.change, ensure_ascii=False),
                json.dumps(signals, ensure_ascii=False),
                json.dumps(step.details, ensure_ascii=False),
                "true" if builder.loop is not None and number >= builder.loop else "false",
                *("" if bound is None else repr(bound) for bound in step.details.get("window", (None, None))),
            ]
        )
    return text.getvalue().encode()
