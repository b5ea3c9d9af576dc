"""Traces: events in a net, one JSON object per line, of witnesses and runs (`docs/records.md`).

A *witness* is a firing sequence found by an analysis, a *run* is the behaviour of a node. Both begin with a
`Header`.

>>> from dineros.metamodel.records import Fire, decode_record, encode_record
>>> line = encode_record(Fire(sequence=1, transition="Say", change={"Words": -1, "Said": 1}))
>>> line
'{"sequence":1,"event":"fire","transition":"Say","change":{"Words":-1,"Said":1}}'
>>> decode_record(line).transition
'Say'
"""

from dineros.metamodel.records.base import EVENTS, SCHEMA, Data, Header, Record, StoredToken
from dineros.metamodel.records.coding import (
    RecordDecoder,
    RecordError,
    decode_record,
    encode_fields,
    encode_record,
    with_checksum,
)
from dineros.metamodel.records.files import (
    current_path,
    node_traces,
    part_path,
    parts_of,
    read_records,
    read_trace,
    traces_of_runs,
    write_records,
)
from dineros.metamodel.records.goals import (
    Accept,
    Accepted,
    Cancel,
    Canceling,
    Feedback,
    Finish,
    Goal,
    GoalStep,
    Hear,
    Outcome,
    Reject,
    TooLate,
)
from dineros.metamodel.records.schema import Aside, Checkpoint, Error, Release, Start, Stop, Timeout
from dineros.metamodel.records.steps import (
    Drop,
    Fire,
    GiveUp,
    Lifecycle,
    Miss,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Take,
    Transfer,
)

__all__ = [
    "EVENTS",
    "SCHEMA",
    "Accept",
    "Accepted",
    "Aside",
    "Cancel",
    "Canceling",
    "Checkpoint",
    "Data",
    "Drop",
    "Error",
    "Feedback",
    "Finish",
    "Fire",
    "GiveUp",
    "Goal",
    "GoalStep",
    "Header",
    "Hear",
    "Lifecycle",
    "Miss",
    "Outcome",
    "Publish",
    "Record",
    "RecordDecoder",
    "RecordError",
    "Reject",
    "Release",
    "Reply",
    "Request",
    "Response",
    "Serve",
    "Signal",
    "Start",
    "Stop",
    "StoredToken",
    "Take",
    "Timeout",
    "TooLate",
    "Transfer",
    "current_path",
    "decode_record",
    "encode_fields",
    "encode_record",
    "node_traces",
    "part_path",
    "parts_of",
    "read_records",
    "read_trace",
    "traces_of_runs",
    "with_checksum",
    "write_records",
]
