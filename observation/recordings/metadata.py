"""Reads ``metadata.yaml`` of a recording of rosbag2, checked field by field."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import Location
from dineros.metamodel.files.reading import read_bytes
from dineros.observation.recordings.errors import RecordingError
from dineros.observation.recordings.plain_yaml import UnplainError, loaded

if TYPE_CHECKING:
    from rosbags.interfaces import Qos

METADATA = "metadata.yaml"
METADATA_LIMIT = 2 * 1024 * 1024
"""Limit of the bytes of the file; recorders write a few kilobytes."""
NEWEST = 9
"""The newest known version of the file."""

_HEAD = "rosbag2_bagfile_information"


@dataclass(frozen=True)
class ToldTopic:
    """A topic of the file."""

    name: str
    type: str
    """`name`, `type`: as written in the file."""
    count: int
    """The number of recorded messages."""
    offered: list[Qos]
    """Qualities of service of its publishers; users edit them for playback."""


@dataclass(frozen=True)
class Metadata:
    """The content of the file."""

    storage: str
    """The format of the files: ``mcap``, ``sqlite3``."""
    files: tuple[str, ...]
    """Their names, without folders."""
    packed: str
    """Use of zstd: none, whole files, or each message."""
    count: int
    """The number of recorded messages."""
    topics: tuple[ToldTopic, ...]
    """In the order of the file."""


def read_metadata(folder: Path) -> Metadata:
    """Read the file of a recording's folder.

    Raises
    ------
    DinerosError
        It cannot be read, is a link, or is malformed.
    """
    path = folder / METADATA
    location = Location(path)
    try:
        value = loaded(read_bytes(path, METADATA_LIMIT, follow_links=False).decode("utf-8"))
        return _metadata(value[_HEAD])
    except UnplainError as error:
        raise RecordingError(str(error), location=location) from error
    except UnicodeDecodeError as error:
        raise RecordingError("is not UTF-8", location=location) from error
    except KeyError as error:
        raise RecordingError(f"lacks {error}", location=location) from error
    except (AttributeError, TypeError, ValueError, RecursionError) as error:
        raise RecordingError(f"was not written by a recorder: {error}", location=location) from error


def _metadata(said: Any) -> Metadata:
    if _number(said, "version") > NEWEST:
        raise ValueError(f"the version {said['version']} is not known; the newest known version is {NEWEST}")
    packed = str(said.get("compression_mode") or "").lower()
    packed = "" if packed == "none" else packed
    if packed not in ("", "file", "message"):
        raise ValueError(f"the compression mode {packed!r:.100} is not known")
    if packed and said.get("compression_format") != "zstd":
        raise ValueError(
            f"the compression format {said.get('compression_format')!r:.100} is not known: zstd is"
        )
    if said["storage_identifier"] not in ("mcap", "sqlite3"):
        raise ValueError(
            f"the storage {said['storage_identifier']!r:.100} is not known: mcap and sqlite3 are"
        )
    # Up to version 3, names begin with the folder of the recording.
    files = tuple(PurePosixPath(_text(name)).name for name in said["relative_file_paths"])
    if len(set(files)) < len(files):
        raise ValueError("relative_file_paths names a file twice")
    topics = tuple(map(_topic, said["topics_with_message_count"]))
    return Metadata(said["storage_identifier"], files, packed, _number(said, "message_count"), topics)


def _topic(said: Any) -> ToldTopic:
    from dineros.observation.recordings.storages import qualities

    topic = said["topic_metadata"]
    form = topic["serialization_format"]
    if form != "cdr":
        raise ValueError(f"the serialization format {form!r:.100} is not known: cdr is")
    offered = qualities(topic.get("offered_qos_profiles") or [])
    return ToldTopic(_text(topic["name"]), _text(topic["type"]), _number(said, "message_count"), offered)


def _number(said: Any, name: str) -> int:
    value = said[name]
    if type(value) is not int or value < 0:
        raise ValueError(f"{name} is {value!r:.100}, which is not a count")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.100} is not a name")
    return value
