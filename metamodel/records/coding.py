"""Converts records to lines of JSON and back; every field is checked."""

from __future__ import annotations

import json
import re
import types
import typing
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal

from dineros.metamodel.base import remembered
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, Location, near_matches, with_article
from dineros.metamodel.json_text import JsonTextError, decode_json
from dineros.metamodel.records.base import EVENTS, SCHEMA, Header, Record, StoredToken
from dineros.metamodel.token_data import Value

Converter = Callable[[Any], Any]

LINE_LIMIT = 64 << 20
"""Maximum length of a line, in bytes."""


class RecordError(DinerosError):
    """A line of a trace is not a record."""


class _WrongTypeError(Exception):
    """A value is not of the type of its field."""


_ENCODER = json.JSONEncoder(ensure_ascii=False, separators=(",", ":"), check_circular=False)


def encode_fields(event: str, sequence: int, values: Mapping[str, Any]) -> str:
    """Return a record as a line of JSON, without checks and without the line feed: for hot paths."""
    return _ENCODER.encode({"sequence": sequence, "event": event, **values})


def with_checksum(line: str) -> bytes:
    """Return a line of JSON with its CRC-32 as the last field, without the line feed.

    The checksum detects damaged files, but no deliberate changes: lines without a checksum are read, too.

    Examples
    --------
    >>> with_checksum('{"sequence":1,"event":"stop"}')
    b'{"sequence":1,"event":"stop","crc":"57e3467e"}'
    """
    content = line[:-1].encode()
    return b'%b,"crc":"%08x"}' % (content, zlib.crc32(content))


_CHECKSUM = re.compile(rb',"crc":"([0-9a-f]{8})"}\s*\Z')


def _has_wrong_checksum(line: bytes) -> bool:
    found = _CHECKSUM.search(line, max(0, len(line) - 40))
    return found is not None and int(found[1], 16) != zlib.crc32(line[: found.start()])


def encode_record(record: Record) -> str:
    """Return a record as a line of JSON, without the line feed; fields with default values are left out."""
    values = {}
    for name, _, default in _layout(type(record)):
        value = getattr(record, name)
        if name == "schema" or value != default:
            values[name] = value
    del values["sequence"]
    return encode_fields(record.event, record.sequence, values)


def decode_record(line: str, location: Location | None = None) -> Record:
    """Read a line of JSON as a record.

    Unknown fields are ignored, so that a trace may contain additional ones.

    Raises
    ------
    RecordError
        The line is not a JSON object, its event or schema is unknown, or a field is missing or of a wrong
        type.
    """
    try:
        values = decode_json(line)
    except JsonTextError as error:
        raise RecordError(error.message, location=location) from None
    if not isinstance(values, dict):
        raise RecordError("no JSON object", location=location)
    event = values.get("event")
    kind = EVENTS.get(event) if isinstance(event, str) else None
    if kind is None:
        hint = near_matches(event, EVENTS) if isinstance(event, str) else f"events are {', '.join(EVENTS)}"
        said = f"unknown event {event!r}" if "event" in values else "no event"
        raise RecordError(said, location=location, hint=hint)
    found: dict[str, Any] = {"location": location}
    for name, convert, default in _layout(kind):
        if name not in values:
            if default is MISSING:
                raise RecordError(f"{event} record without {name!r}", location=location)
            continue
        try:
            found[name] = convert(values[name])
        except _WrongTypeError as error:
            shown = json.dumps(values[name], ensure_ascii=False)
            shown = shown if len(shown) <= 40 else f"{shown[:37]}..."
            said = f"{name!r} of {with_article(str(event))} record is {error}, not {shown}"
            raise RecordError(said, location=location) from None
    if kind is Header and found.get("schema", SCHEMA) > SCHEMA:
        raise RecordError(
            f"schema {found['schema']} is newer than this program, which knows {SCHEMA}",
            location=location,
            hint="use a later version of DiNeROS",
        )
    return kind(**found)


class RecordDecoder:
    """Reads a trace in pieces, such as a file that is still being written.

    Parameters
    ----------
    source : Path or str, optional
        The file, for error messages.

    Attributes
    ----------
    position : int
        Bytes up to the end of the last complete line.
    line : int
        Lines read so far.
    """

    def __init__(self, source: Path | str | None = None) -> None:
        self.source = source
        self.position = 0
        self.line = 0
        self._complete: deque[bytes] = deque()
        self._begun: list[bytes] = []  # pieces of the incomplete line
        self._size = 0
        self._overlong = f"is a line of more than {LINE_LIMIT >> 20} MiB"

    def feed(self, chunk: bytes) -> Iterator[Record]:
        """Yield the records of the lines that are now complete.

        Raises
        ------
        RecordError
            A line is not a record, or longer than `LINE_LIMIT`.
        """
        first, *others = chunk.split(b"\n")
        self._begin(first)
        for other in others:
            self._complete.append(b"".join(self._begun))
            self._begun, self._size = [], 0
            self._begin(other)
        while self._complete:
            line = self._complete.popleft()
            self.position += len(line) + 1
            self.line += 1
            if line.strip():
                yield self._decode(line, self.line)
        if self._size > LINE_LIMIT:
            raise RecordError(self._overlong, location=Location(self.source, self.line + 1))

    def forget(self) -> None:
        """Discard incomplete data: it will be fed again, from `position` on."""
        self._complete.clear()
        self._begun, self._size = [], 0

    def close(self) -> Record | None:
        """Return the record of a last line without a line feed.

        A crash may have left an incomplete line: it was never recorded, and None is returned.
        """
        line = b"".join(self._begun)
        self.forget()
        if not line.strip():
            return None
        try:
            record = self._decode(line, self.line + 1)
        except RecordError:
            if _is_json(line):
                raise
            return None
        self.line += 1
        self.position += len(line)
        return record

    def _begin(self, piece: bytes) -> None:
        self._begun.append(piece)
        self._size += len(piece)

    def _decode(self, line: bytes, number: int) -> Record:
        location = Location(self.source, number)
        if len(line) > LINE_LIMIT:
            raise RecordError(self._overlong, location=location)
        if _has_wrong_checksum(line):
            raise RecordError(
                "its checksum is wrong: the record is damaged",
                location=location,
                hint="restore the file; to read a record that was changed on purpose, remove its crc",
            )
        try:
            text = line.decode("utf-8")
        except UnicodeDecodeError as error:
            raise RecordError(f"no UTF-8: {error.reason}", location=location) from None
        return decode_record(text, location)


def _is_json(line: bytes) -> bool:
    try:
        decode_json(line)
    except JsonTextError:
        return False
    return True


@remembered
def _layout(kind: type[Record]) -> tuple[tuple[str, Converter, Any], ...]:
    """Return name, converter and default (or MISSING) of each JSON field of a class of records."""
    hints = typing.get_type_hints(kind, None, {"Value": Value})  # the types of token values are recursive
    return tuple(
        (
            field.name,
            _converter(hints[field.name]),
            field.default_factory() if field.default_factory is not MISSING else field.default,
        )
        for field in fields(kind)
        if field.name != "location"
    )


def _converter(hint: Any) -> Converter:
    """Return a function that checks a JSON value against a type, and converts it if JSON lacks the type."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return lambda value: value
    if hint == SignalSetting:
        return _setting
    if origin in (types.UnionType, typing.Union):
        options = [option for option in arguments if option is not type(None)]
        inner = _converter(options[0])
        return lambda value: None if value is None else inner(value)
    if origin is Literal:
        return _one_of(arguments)
    if hint is StoredToken:
        return _token
    if origin is list:
        return _list_of(_converter(arguments[0]))
    if origin is dict:
        # The data of balloon tokens is checked by the runtime, which knows their type.
        is_union = typing.get_origin(arguments[1]) in (types.UnionType, typing.Union)
        free = arguments[1] is Any or (is_union and arguments[1] != SignalSetting)
        return _object if free else _map_to(_converter(arguments[1]))
    return _scalar(hint)


_ARTICLES = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}


def _scalar(kind: type) -> Converter:
    def convert(value: Any) -> Any:
        if type(value) is kind:
            return value
        if kind is float and type(value) is int:
            return float(value)
        raise _WrongTypeError(_ARTICLES[kind])

    return convert


def _setting(value: Any) -> SignalSetting:
    if not isinstance(value, (bool, str)):
        raise _WrongTypeError("true, false or the name of a value")
    return value


def _one_of(choices: tuple[Any, ...]) -> Converter:
    def convert(value: Any) -> Any:
        if value not in choices:
            raise _WrongTypeError(f"one of {', '.join(map(str, choices))}")
        return value

    return convert


def _object(value: Any) -> Any:
    if not isinstance(value, dict):
        raise _WrongTypeError("an object")
    return value


def _map_to(inner: Converter) -> Converter:
    def convert(value: Any) -> Any:
        return {name: inner(element) for name, element in _object(value).items()}

    return convert


def _list_of(inner: Converter) -> Converter:
    def convert(value: Any) -> Any:
        if not isinstance(value, list):
            raise _WrongTypeError("a list")
        return [inner(element) for element in value]

    return convert


def _token(value: Any) -> StoredToken:
    if (
        not isinstance(value, list)
        or len(value) != 2
        or type(value[0]) is not int
        or not isinstance(value[1], dict)
    ):
        raise _WrongTypeError("a list of tokens [id, data]")
    return StoredToken(value[0], value[1])
