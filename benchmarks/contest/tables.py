"""Results of the contest's nets as tables: per family, per examination, in all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

Record = dict[str, Any]
OUTCOMES = ("right", "wrong", "unknown")

GROUPS = {
    "StateSpace": "state spaces",
    "Reachability": "reachability and bounds",
    "UpperBounds": "reachability and bounds",
    "CTL": "CTL",
    "LTL": "LTL",
}


def group_of(examination: str) -> str:
    """Return what a target is set for."""
    if examination == "ReachabilityDeadlock":
        return "global properties"
    return next(
        (group for word, group in GROUPS.items() if examination.startswith(word)), "global properties"
    )


def print_tables(records: Iterable[Record]) -> int:
    """Print tables and all wrong answers; return how many these are."""
    found = list(records)
    for title, key in (
        ("family", lambda r: r["net"].split("-")[0]),
        ("examination", lambda r: r["examination"]),
        ("group", lambda r: group_of(r["examination"])),
        ("all", lambda r: "all"),
    ):
        print_table(title, found, key)
    wrong = [record for record in found if record["outcome"] == "wrong"]
    for record in wrong:
        asked = f"{record['net']} {record['examination']} {record['id']}"
        print(f"wrong: {asked}: {record['value']}, expected {record['expected']} ({record['technique']})")
    return len(wrong)


def print_table(title: str, records: list[Record], key: Callable[[Record], str]) -> None:
    """Print one row for each group of records; seconds are of the processor."""
    rows: dict[str, list[Record]] = {}
    for record in records:
        rows.setdefault(key(record), []).append(record)
    print(f"\n| {title} | right | wrong | unknown | answered | seconds |\n|---|---|---|---|---|---|")
    for name, group in sorted(rows.items()):
        counts = [sum(record["outcome"] == outcome for record in group) for outcome in OUTCOMES]
        cells = [name, *map(str, counts), f"{100 * (counts[0] + counts[1]) / len(group):.1f} %"]
        print(f"| {' | '.join([*cells, f'{seconds_of(group):.0f}'])} |")


def seconds_of(group: list[Record]) -> float:
    """Add up what processes took; a count of a state space is four verdicts of one question."""
    return float(
        sum(record["processor"] / (4 if record["examination"] == "StateSpace" else 1) for record in group)
    )
