"""Reading recordings of rosbag2, MCAP and SQLite, by the library rosbags, in memory that stays flat.

What a recording holds is nobody's word: whatever is wrong with one ends in one line. The library lets errors
of many kinds through where a file is damaged, so all of them are caught here, and only here.
"""

from __future__ import annotations

import os
import re
from collections import defaultdict
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple, Self

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import open_plain, read_bytes
from dineros.observation.systems import (
    OF_EVENTS,
    ObservedSystem,
    RecordedService,
    RecordedTopic,
    is_house_service,
    is_house_topic,
    is_of_action,
    quality_of_profile,
)

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.interfaces import QosTime as Duration
    from rosbags.rosbag2 import Reader

METADATA = "metadata.yaml"
METADATA_LIMIT = 4 * 1024 * 1024
"""Bytes of a recording's ``metadata.yaml``: what is larger was written by nobody's recorder."""

_STORAGE = (".mcap", ".db3")
_TOPIC = re.compile(r"/[A-Za-z_~{}][A-Za-z0-9_/~{}]{0,254}")
_TYPE = re.compile(r"[a-z][a-z0-9_]{0,99}/(msg|srv|action)/[A-Z][A-Za-z0-9_]{0,99}")
_EVENT = "_Event"
_SPECIAL = frozenset("?#%")
"""Characters that mean something else in the address by which the library opens a database."""

_ENDLESS = 2_147_483_647
"""Seconds from which on a duration of a quality of service is without bound."""


class RecordingError(DinerosError):
    """A recording cannot be read: it is damaged, cut off, empty, or none."""


class RecordedMessage(NamedTuple):
    """A message of a recording. Who published it, rosbag2 does not write down.

    Attributes
    ----------
    topic : str
        Full name of the topic.
    time : int
        When the recorder received it, in nanoseconds.
    data : bytes
        The message as it was sent (CDR).
    """

    topic: str
    time: int
    data: bytes


class Recording:
    """A recording of rosbag2, to be used in a ``with`` block.

    Parameters
    ----------
    path : Path
        The folder with ``metadata.yaml``, or one file of MCAP or SQLite.

    Attributes
    ----------
    topics : tuple of RecordedTopic
        In order of their names.
    services : tuple of RecordedService
        Services that told of their calls on some of these topics (service introspection).
    count : int
        How many messages there are, by the recording's own word.
    start, duration : int
        In nanoseconds, by the recording's own word.

    Raises
    ------
    RecordingError
        It is damaged, cut off, empty, or none; or the library is not installed.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._check_files()
        with self._guarded():
            self._reader = _reader(path)
            self._reader.open()
        try:
            with self._guarded():
                self.count = int(self._reader.message_count)
                self.start, self.duration = int(self._reader.start_time), int(self._reader.duration)
                self.topics = self._topics(self._reader.connections)
                self.services = tuple(map(_service, filter(_is_of_events, self.topics)))
            if not self.count:
                raise self.error("holds no message")
        except DinerosError:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the files."""
        if self._reader.is_open:
            self._reader.close()

    def system(self) -> ObservedSystem:
        """Return what the recording tells of the system: topics and services, and no nodes.

        Without those that ROS makes by itself, as they are not told of a running graph either.
        """
        topics = (each for each in self.topics if not is_house_topic(each.name, each.type))
        return ObservedSystem(
            str(self._path),
            topics=tuple(topic for topic in topics if not is_of_action(topic.name)),
            services=tuple(
                service
                for service in self.services
                if not is_house_service(service.type) and not is_of_action(service.name)
            ),
        )

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """Yield the messages in order of their times.

        Parameters
        ----------
        topics : collection of str, optional
            Full names of those to yield; None: all.

        Raises
        ------
        RecordingError
            The recording is damaged, which may show at a late message only.
        """
        wanted = [each for each in self._reader.connections if topics is None or each.topic in topics]
        if not wanted:
            return
        with self._guarded():
            for connection, time, data in self._reader.messages(wanted):
                yield RecordedMessage(connection.topic, int(time), data)

    def _check_files(self) -> None:
        """Look at what the library will open: plain files that are not empty."""
        try:
            if self._path.is_dir():
                self._check_folder()
            else:
                self._check_storage(self._path)
        except FileNotFoundError:
            raise self.error("there is no such recording") from None
        except OSError as error:
            raise self.error(f"cannot be read: {error.strerror}") from error

    def _check_folder(self) -> None:
        files = sorted(file for file in self._path.iterdir() if file.suffix in (*_STORAGE, ".zstd"))
        if not files:
            raise self.error(
                "holds no recording", f"a recording of rosbag2 is a {METADATA} and files beside it"
            )
        if not (self._path / METADATA).exists():
            raise self.error(
                f"has no {METADATA}: the recorder did not end it",
                f"`ros2 bag reindex` writes one; or name the file: {files[0].name}",
            )
        read_bytes(self._path / METADATA, METADATA_LIMIT)
        for file in files:
            self._check_storage(file)

    def _check_storage(self, file: Path) -> None:
        descriptor = open_plain(file)
        try:
            size = os.fstat(descriptor).st_size
        finally:
            os.close(descriptor)
        if not size:
            raise RecordingError("is empty", location=Location(file))
        if file.suffix == ".db3":
            if _SPECIAL & set(str(file)):
                raise RecordingError(
                    "a database cannot be read from a path with ?, # or %",
                    location=Location(file),
                    hint="rename it",
                )
            left = file.with_name(f"{file.name}-wal")
            if left.exists() and left.stat().st_size:
                raise RecordingError(
                    f"is not complete: {left.name} holds messages that were not put into it",
                    location=Location(file),
                    hint=f'`sqlite3 {file.name} "PRAGMA wal_checkpoint(TRUNCATE)"` does',
                )

    def _topics(self, connections: Collection[Connection]) -> tuple[RecordedTopic, ...]:
        by_name: defaultdict[str, list[Connection]] = defaultdict(list)
        for connection in connections:
            by_name[connection.topic].append(connection)
        return tuple(self._topic(name, by_name[name]) for name in sorted(by_name))

    def _topic(self, name: str, connections: list[Connection]) -> RecordedTopic:
        if not _TOPIC.fullmatch(name):
            raise self.error(f"{name!r:.100} is no name of a topic")
        types = sorted({connection.msgtype for connection in connections})
        for kind in types:
            if not _TYPE.fullmatch(kind):
                raise self.error(
                    f"topic {name} is of the unknown type {kind!r:.100}", "a type is like std_msgs/msg/String"
                )
        if len(types) > 1:
            raise self.error(f"topic {name} is of several types: {', '.join(types):.300}")
        offered = [
            quality_of_profile(quality, _seconds)
            for connection in connections
            for quality in getattr(connection.ext, "offered_qos_profiles", ())
        ]
        return RecordedTopic(name, types[0], tuple(offered), sum(each.msgcount for each in connections))

    def error(self, message: str, hint: str | None = None) -> RecordingError:
        """Return that something is wrong with the recording."""
        return RecordingError(message, location=Location(self._path), hint=hint)

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except (DinerosError, GeneratorExit):
            raise
        except Exception as error:  # whatever the library, the database or a decompressor says
            said = " ".join(str(error).split()).replace(f"{self._path}/", "").replace(str(self._path), "it")
            raise self.error(
                f"is damaged or cut off: {said or type(error).__name__:.300}".rstrip("."),
                "`ros2 bag reindex` or `mcap recover` may save what is whole",
            ) from error


def _reader(path: Path) -> Reader:
    try:
        from rosbags.rosbag2 import Reader
    except ModuleNotFoundError:
        raise DinerosError(
            "recordings need the package rosbags", hint="pip install 'dineros[recordings]'"
        ) from None
    if not path.is_dir() and path.suffix not in _STORAGE:
        raise RecordingError(
            "is no recording of rosbag2",
            location=Location(path),
            hint=f"a folder with {METADATA}, or a file named *.mcap or *.db3",
        )
    return Reader(path)


def _is_of_events(topic: RecordedTopic) -> bool:
    return topic.name.endswith(OF_EVENTS) and "/srv/" in topic.type and topic.type.endswith(_EVENT)


def _service(topic: RecordedTopic) -> RecordedService:
    return RecordedService(
        topic.name.removesuffix(OF_EVENTS), topic.type.removesuffix(_EVENT), topic.messages
    )


def _seconds(duration: Duration) -> float | None:
    """Return a duration in seconds, None without bound: zero and the largest number say so."""
    if duration.sec >= _ENDLESS or (not duration.sec and not duration.nsec):
        return None
    return duration.sec + duration.nsec / 1e9
