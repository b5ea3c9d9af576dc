"""The traces of several nodes as one script: nothing is received before it was sent."""

from __future__ import annotations

from dineros.generators.workspace.scripts import _merged
from dineros.metamodel.records import Accept, Accepted, Goal, Record


def test_an_acceptance_is_known_after_it_was_given() -> None:
    client: list[Record] = [
        Goal(sequence=1, time=10.0, channel="drive", client="pilot", message="a"),
        Accepted(sequence=2, time=11.0, channel="drive", client="pilot", message="a"),
    ]
    # The clock of the server is ahead.
    server: list[Record] = [Accept(sequence=1, time=15.0, channel="drive", instance=1, message="a")]
    assert [record.event for record in _merged({"pilot": client, "car": server})] == [
        "goal",
        "accept",
        "accepted",
    ]
