"""Large token data: stored once next to the trace, so that lines stay short without loss of data.

In the record, the value of a large field is ``{"$stored": DIGEST, "$bytes": N, "$start": TEXT}``; the value
itself is the JSON text in ``NODE.data/DIGEST.json``. If a checkpoint is large although no single field is,
the data of all tokens of a place is stored as one value. A place that is unchanged since an earlier
checkpoint is not written again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, cast

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.records import Checkpoint, Record, StoredToken
from dineros.metamodel.records.files import data_folder

_KEYS = {"$stored", "$bytes", "$start"}
_SLACK = 2.0
"""Seconds by which file times and record times may differ."""

_START = 60
"""Number of characters of a stored value that the record shows."""

STORED_LIMIT = 1 << 30
"""Maximum size of a value that is read back, in bytes."""

_PLACE_BYTES = 64 << 10
"""Maximum size of a place's token data in the line of a large checkpoint, in bytes."""

_OF_PLACES = ("marking", "history")
"""Fields of a checkpoint that hold the tokens of places."""

R = TypeVar("R", bound=Record)


class Outlined:
    """Large values of one node's trace.

    Parameters
    ----------
    folder : Path
        Folder of the trace.
    node : str
        Id of the node.
    limit : int
        Maximum size of a field's JSON in a line, in bytes.
    synchronise : bool
        Whether to wait until the data is on disk.

    Attributes
    ----------
    written : int
        Bytes written so far.
    """

    def __init__(self, folder: Path, node: str, limit: int = 4096, synchronise: bool = False) -> None:
        self.folder = data_folder(folder, node)
        self.limit = limit
        self._synchronise = synchronise
        self.written = 0

    def outline(self, fields: dict[str, Any]) -> dict[str, Any]:
        """Return the fields of a record with large values stored separately."""
        return _map_data(fields, self._outline_data)

    def outline_places(self, fields: dict[str, Any]) -> dict[str, Any]:
        """Return the fields of a checkpoint with the data of large places stored separately."""
        changed, apart = dict(fields), {}
        for name in _OF_PLACES:
            stored = {}
            for place, tokens in fields.get(name, {}).items():
                text = _json([data for _, data in tokens])
                if len(text) > _PLACE_BYTES:
                    stored[place] = self._store(text)
            if stored:
                apart[name] = stored
                changed[name] = {
                    place: [[id, {}] for id, _ in tokens] if place in stored else tokens
                    for place, tokens in fields[name].items()
                }
        return {**changed, "apart": apart} if apart else fields

    def prune(self, time: float) -> None:
        """Remove the values to which no record since a time refers."""
        with contextlib.suppress(FileNotFoundError):
            for path in self.folder.iterdir():
                if path.suffix == ".json" and path.lstat().st_mtime < time - _SLACK:
                    path.unlink(missing_ok=True)

    def inline(self, record: R) -> R:
        """Return a record with its large values read back.

        Raises
        ------
        DinerosError
            A stored value is missing or has been changed.
        """
        if isinstance(record, Checkpoint) and record.apart:
            record = cast(R, self._inline_places(record))
        names = [name for name in _PLACES if hasattr(record, name)]
        values = {name: getattr(record, name) for name in names}
        read = _map_data(values, self._inline_data)
        changed = {name: value for name, value in read.items() if value is not values[name]}
        return replace(record, **changed) if changed else record

    def _outline_data(self, data: dict[str, Any]) -> dict[str, Any]:
        return {name: self._outline_value(value) for name, value in data.items()}

    def _outline_value(self, value: Any) -> Any:
        if isinstance(value, (int, float)) or _is_stored(value):
            return value
        text = _json(value)
        return value if len(text.encode()) <= self.limit else self._store(text)

    def _store(self, text: str) -> dict[str, Any]:
        """Store a JSON text, unless it is stored already, and return the reference to it."""
        content = text.encode()
        digest = hashlib.sha256(content).hexdigest()
        path = self.folder / f"{digest}.json"
        if not path.exists():
            self.folder.mkdir(exist_ok=True)
            write_atomically(path, content, follow_links=False, synchronise=self._synchronise)
            self.written += len(content)
        else:
            os.utime(path, follow_symlinks=False)  # now a record refers to it
        return {"$stored": digest, "$bytes": len(content), "$start": text[:_START]}

    def _inline_places(self, record: Checkpoint) -> Checkpoint:
        read: dict[str, dict[str, list[StoredToken]]] = {name: {} for name in _OF_PLACES}
        for name in _OF_PLACES:
            known: dict[str, list[StoredToken]] = getattr(record, name)
            for place, stored in record.apart.get(name, {}).items():
                data = self._read(stored) if _is_stored(stored) else None
                tokens = known.get(place, [])
                if not isinstance(data, list) or len(data) != len(tokens):
                    raise DinerosError(
                        f"the data of the tokens of {place!r} is not stored", location=record.location
                    )
                read[name][place] = [StoredToken(old.id, new) for old, new in zip(tokens, data, strict=True)]
        return replace(
            record,
            marking={**record.marking, **read["marking"]},
            history={**record.history, **read["history"]},
            apart={},
        )

    def _inline_data(self, data: dict[str, Any]) -> dict[str, Any]:
        if not any(map(_is_stored, data.values())):
            return data
        return {name: self._read(value) if _is_stored(value) else value for name, value in data.items()}

    def _read(self, value: dict[str, Any]) -> Any:
        path = self.folder / f"{value['$stored']}.json"
        content = read_bytes(path, min(max(value["$bytes"], 0), STORED_LIMIT), follow_links=False)
        if hashlib.sha256(content).hexdigest() != value["$stored"]:
            raise DinerosError("differs from what the trace stored", location=Location(path))
        return decode_json(content, location=Location(path))


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def _is_stored(value: Any) -> bool:
    # No map field of a token looks like this: the values of a map have one type.
    if not isinstance(value, dict) or value.keys() != _KEYS or not isinstance(value["$bytes"], int):
        return False
    # It becomes part of a file name, and a trace is untrusted.
    return isinstance(value["$stored"], str) and re.fullmatch(r"[0-9a-f]{64}", value["$stored"]) is not None


def _map_data(fields: dict[str, Any], change: Callable[[dict[str, Any]], dict[str, Any]]) -> dict[str, Any]:
    """Return fields of a record with all token data changed; unchanged fields stay the same objects."""
    return {
        name: _PLACES[name](value, change) if name in _PLACES else value for name, value in fields.items()
    }


def _tokens(value: Any, change: Callable[[dict[str, Any]], dict[str, Any]]) -> Any:
    changed = {
        place: [StoredToken(id, change(data)) for id, data in tokens] for place, tokens in value.items()
    }
    same = all(
        new.data is old[1]
        for place, tokens in changed.items()
        for new, old in zip(tokens, value[place], strict=True)
    )
    return value if same else changed


def _requests(value: Any, change: Callable[[dict[str, Any]], dict[str, Any]]) -> Any:
    def changed(request: dict[str, Any]) -> dict[str, Any]:
        return {**request, "data": change(request["data"])}

    # In older journals, with one request per client, it is the request itself.
    return {
        key: changed(found) if isinstance(found, dict) else [changed(request) for request in found]
        for key, found in value.items()
    }


def _responses(value: Any, change: Callable[[dict[str, Any]], dict[str, Any]]) -> Any:
    return {
        channel: {message: change(data) for message, data in kept.items()} for channel, kept in value.items()
    }


_PLACES: dict[str, Callable[[Any, Callable[[dict[str, Any]], dict[str, Any]]], Any]] = {
    "marking": _tokens,
    "made": _tokens,
    "history": _tokens,
    "data": lambda value, change: change(value),
    "requests": _requests,
    "responses": _responses,
}
"""Fields of records that hold token data."""
