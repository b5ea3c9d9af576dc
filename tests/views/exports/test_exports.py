"""Exports, read back with the libraries of those who read them."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from dataclasses import replace
from typing import Any

import pytest
from mcap.reader import make_reader

from dineros.metamodel.records import Signal
from dineros.views.exports import EXPORTS, export
from tests.views.samples import lasso, run, schedule
from tests.views.traces.test_building import built

LOAD = {"LeftCellObjects.publisher.SortRed.Load": ("LeftCellObjects", "publisher", "SortRed")}


def mcap(content: bytes) -> list[tuple[str, str, int, dict[str, Any]]]:
    reader = make_reader(io.BytesIO(content), validate_crcs=True)
    return [
        (channel.topic, schema.name if schema else "", message.log_time, json.loads(message.data))
        for schema, channel, message in reader.iter_messages(log_time_order=True)
    ]


def test_mcap_has_steps_signals_queues_calls_and_marking() -> None:
    builder = built(lasso(), loads=LOAD)
    messages = mcap(export(builder, ".mcap"))
    topics = Counter(topic for topic, *_ in messages)
    assert topics["/dineros/steps"] == topics["/dineros/log"] == 9
    values = [data["value"] for topic, _, _, data in messages if topic == "/dineros/signals/Danger"]
    assert values == [False, True, False]
    queue = [
        data for topic, _, _, data in messages if topic == "/dineros/topics/LeftCellObjects/publisher/SortRed"
    ]
    assert [(data["event"], data["level"], data["lost"], data["capacity"]) for data in queue] == [
        ("publish", 1, 0, 10), ("drop", 1, 1, 10)]  # fmt: skip
    states = [
        data["state"] for topic, _, _, data in messages if topic == "/dineros/services/SensorService/safety"
    ]
    assert states == ["requested", "served"]
    marking: dict[str, int] = {}
    for topic, _, _, data in messages:
        if topic == "/dineros/marking":
            marking |= data["places"]
    assert marking == builder.marking
    logs = [data["level"] for topic, schema, _, data in messages if schema == "foxglove.Log"]
    assert logs.count(4) == 1  # the lost message


def test_mcap_schemas_describe_the_messages() -> None:
    content = export(built(*run().values()), ".mcap")
    reader = make_reader(io.BytesIO(content))
    for schema, _, message in reader.iter_messages():
        assert schema is not None
        assert schema.encoding == "jsonschema"
        assert set(json.loads(message.data)) <= set(json.loads(schema.data)["properties"])
    (about,) = reader.iter_metadata()
    assert about.metadata["model"] == "sorting"


def test_times_of_a_run_are_kept_and_never_fall() -> None:
    builder = built(*run().values())
    times = [time for topic, _, time, _ in mcap(export(builder, ".mcap")) if topic == "/dineros/steps"]
    assert times == sorted(times)
    assert times[0] == pytest.approx((builder.steps[0].time or 0) * 1e9)


def test_csv_has_a_row_for_each_step() -> None:
    builder = built(lasso())
    rows = list(csv.DictReader(io.StringIO(export(builder, ".csv").decode())))
    assert len(rows) == 9
    assert rows[2]["text"] == "SelectRed"
    assert json.loads(rows[2]["change"]) == {"RedObjects": -1, "SortRed": 1}
    assert json.loads(rows[7]["signals"]) == {"Red": True, "Blue": False, "Danger": True}
    assert [row["loop"] for row in rows] == ["false"] * 7 + ["true"] * 2


@pytest.mark.parametrize("suffix", EXPORTS)
def test_a_trace_without_steps(suffix: str) -> None:
    scribe = lasso()
    scribe.records = scribe.records[:1]
    assert isinstance(export(built(scribe), suffix), bytes)


def test_a_schedule_is_exported_with_its_windows() -> None:
    builder = built(schedule())
    rows = list(csv.DictReader(io.StringIO(export(builder, ".csv").decode())))
    assert [(row["time"], row["earliest"], row["latest"]) for row in rows] == [
        ("100.0", "100.0", "100.0"),
        ("130.0", "130.0", "190.0"),
        ("135.0", "135.0", ""),
    ]
    steps = [
        (message.log_time, json.loads(message.data)["details"]["window"])
        for _, channel, message in make_reader(io.BytesIO(export(builder, ".mcap"))).iter_messages()
        if channel.topic == "/dineros/steps"
    ]
    assert steps == [
        (100 * 10**9, [100.0, 100.0]),
        (130 * 10**9, [130.0, 190.0]),
        (135 * 10**9, [135.0, None]),
    ]


@pytest.mark.parametrize("values", [["high", True, False, "high"], ["", False, ""]])
def test_a_signal_with_names_and_truth_values_is_exported(values: list[str | bool]) -> None:
    """A trace of others may have both; `true` and `false` are then names."""
    scribe = lasso()
    first, signal = next(each for each in enumerate(scribe.records) if isinstance(each[1], Signal))
    assert isinstance(signal, Signal)
    changed = [replace(signal, signal="Mixed", value=value) for value in values]
    scribe.records[first : first + 1] = changed
    builder = built(scribe)
    rows = list(csv.DictReader(io.StringIO(export(builder, ".csv").decode())))
    found = [json.loads(row["signals"])["Mixed"] for row in rows][first - 1 :][: len(values)]
    assert found == [value if isinstance(value, str) else str(value).lower() for value in values]
    assert export(builder, ".mcap")
