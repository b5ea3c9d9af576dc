"""Reads recordings of rosbag2, MCAP and SQLite, in bounded memory.

Recordings are untrusted input; every failure becomes a one-line `RecordingError`. The library raises errors
of many kinds for damaged files, so all of them are caught here, and only here.
"""

from __future__ import annotations

import heapq
import itertools
import re
from collections import defaultdict
from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple, Self

from dineros.metamodel.errors import DinerosError, Location, counted
from dineros.metamodel.limits import exceeds
from dineros.observation.recordings.errors import RecordingError
from dineros.observation.recordings.metadata import METADATA, Metadata, read_metadata
from dineros.observation.systems import (
    OF_EVENTS,
    ObservedSystem,
    RecordedService,
    RecordedTopic,
    full_name,
    is_house_service,
    is_house_topic,
    is_of_action,
    quality_of_profile,
)

if TYPE_CHECKING:
    from rosbags.interfaces import Qos
    from rosbags.interfaces import QosTime as Duration

    from dineros.observation.recordings.files import StoredFile
    from dineros.observation.recordings.storages import Storage, Stored

_KINDS = {".mcap": "mcap", ".db3": "sqlite3"}
_PACKED = ".zstd"
_TOPIC = re.compile(r"[A-Za-z0-9_/~{}]{1,256}")
_TYPE = re.compile(r"[a-z][a-z0-9_]{0,99}/(msg|srv|action)/[A-Z][A-Za-z0-9_]{0,99}")
_EVENT = "_Event"

_ENDLESS = 2_147_483_647
"""Seconds from which a duration of a quality of service counts as unbounded."""

_new_tuple = tuple.__new__
"""Makes a message without a call of Python code; recordings have millions."""

_REINDEX = "`ros2 bag reindex` or `mcap recover` may restore the intact part"


class RecordedMessage(NamedTuple):
    """A message of a recording. rosbag2 does not store its publisher."""

    topic: str
    """Full name of the topic."""
    time: int
    """When the recorder received it, in nanoseconds."""
    data: bytes
    """The message as it was sent (CDR)."""


@dataclass
class _RecordedTopic:
    """A topic of metadata and files; messages: their number according to either."""

    types: set[str] = field(default_factory=set)
    offered: list[Qos] = field(default_factory=list)
    by_files: int = 0
    by_metadata: int | None = None

    @property
    def messages(self) -> int:
        """The number of recorded messages, the greatest of all sources."""
        return max(self.by_files, self.by_metadata or 0)


class Recording:
    """A recording of rosbag2, to be used in a ``with`` block.

    `path`: the folder with ``metadata.yaml``, in which links are not followed, or one file of MCAP or SQLite.

    Attributes
    ----------
    topics : tuple of RecordedTopic
        In order of their names. The offers of publishers come from the files, or from ``metadata.yaml`` if
        the files have none.
    services : tuple of RecordedService
        Services that published their calls on some of these topics (service introspection).
    left_out : tuple of str
        Topics that cannot be read, each with its reason; their messages are left out.
    count : int
        How many messages there are on `topics`, by the recording's own word.
    start, duration : int
        In nanoseconds, by the recording's own word.

    Raises
    ------
    RecordingError
        It is damaged, cut off, empty, not a recording, or holds fewer messages than it says.
    DinerosError
        The library is not installed.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._open = ExitStack()
        self._storages: list[tuple[Path, Storage]] = []
        self._metadata: Metadata | None = None
        self._told: defaultdict[str, _RecordedTopic] = defaultdict(_RecordedTopic)
        self._bytes = 0
        left_out: list[str] = []
        try:
            with self._guarded(path):
                self._open_files()
                self._compare_counts()
                self.topics = tuple(self._topics(left_out))
            self.left_out = tuple(left_out)
            self.services = tuple(map(_service, filter(_is_of_events, self.topics)))
            self.count = sum(topic.messages or 0 for topic in self.topics)
            self.start, self.duration = self._times()
            if not self.count:
                more = f" that can be read; ignored: {'; '.join(left_out)}" if left_out else ""
                raise self.error(f"holds no message{more}")
        except BaseException:
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
        self._open.close()

    def system(self) -> ObservedSystem:
        """Return the system of the recording: topics and services, without nodes.

        Topics that ROS creates itself are omitted, as for a running graph.
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

        `topics`: names of those to yield; None: all.

        Raises
        ------
        RecordingError
            The recording is damaged, which may be detected only at a late message, or holds fewer messages
            than declared.
        """
        wanted = [each.name for each in self.topics if topics is None or each.name in topics]
        found = dict.fromkeys(wanted, 0)
        yield from self._merged(found)
        for name in wanted:
            self._check_count(name, self._told[name].messages, found[name])

    def _merged(self, found: dict[str, int]) -> Iterator[RecordedMessage]:
        """Return the messages of all files: one file after the other, or side by side if their times overlap.

        Parameters
        ----------
        found : dict of str to int
            The topics of the messages to yield; the messages of each are counted here.
        """
        streams = [self._of_storage(path, storage, found) for path, storage in self._storages]
        times = [storage.metadata for _, storage in self._storages]
        if all(one.end_time <= other.start_time + 1 for one, other in itertools.pairwise(times)):
            return itertools.chain.from_iterable(streams)
        return heapq.merge(*streams, key=lambda message: message.time)

    def _of_storage(self, path: Path, storage: Storage, found: dict[str, int]) -> Iterator[RecordedMessage]:
        from dineros.observation.recordings.files import most_unpacked
        from dineros.observation.recordings.storages import Database, unpacked_messages

        connections = [each for each in storage.connections if each.topic in found]
        if not connections:
            return
        new, is_packed = _new_tuple, self._metadata is not None and self._metadata.packed == "message"
        with self._guarded(path):
            if isinstance(storage, Database) and not is_packed:
                topics = {each.id: each.topic for each in connections}
                for number, time, data in storage.rows(connections):
                    topic = topics[number]
                    found[topic] += 1
                    yield new(RecordedMessage, (topic, int(time), data))
                return
            messages: Iterator[Stored] = storage.messages(connections)
            if is_packed:
                messages = unpacked_messages(messages, most_unpacked(self._bytes), path)
            for connection, time, data in messages:
                topic = connection.topic
                found[topic] += 1
                yield new(RecordedMessage, (topic, int(time), data))

    def _open_files(self) -> None:
        if find_spec("rosbags") is None:
            raise DinerosError(
                "recordings need the package rosbags", hint="pip install 'dineros[recordings]'"
            )
        from dineros.observation.recordings.files import stored

        if self._path.is_dir():
            files = self._files_of_folder()
        elif self._path.exists() or self._path.is_symlink():
            files = [self._path]
            if self._path.suffix not in _KINDS:
                raise self.error(
                    "is not a recording of rosbag2",
                    f"a folder with {METADATA}, or a file named *.mcap or *.db3",
                )
        else:
            raise self.error("this recording does not exist")
        is_folder = self._metadata is not None
        opened = [self._open.enter_context(stored(file, follow_links=not is_folder)) for file in files]
        self._refuse_unnamed()
        self._bytes = sum(file.size for file in opened)
        self._open_storages(opened)

    def _files_of_folder(self) -> list[Path]:
        files = self._present()
        if not files:
            raise self.error(
                "holds no recording", f"a recording of rosbag2 is a {METADATA} and files next to it"
            )
        if not (self._path / METADATA).exists():
            raise self.error(
                f"has no {METADATA}: the recorder was not stopped properly",
                f"`ros2 bag reindex` writes one; or name the file: {files[0].name}",
            )
        self._metadata = read_metadata(self._path)
        return [self._path / name for name in self._metadata.files]

    def _present(self) -> list[Path]:
        return sorted(file for file in self._path.iterdir() if file.suffix in (*_KINDS, _PACKED))

    def _refuse_unnamed(self) -> None:
        """Reject files that the metadata do not name: their messages would count as not sent."""
        if self._metadata is None:
            return
        named = {name.removesuffix(_PACKED) for name in self._metadata.files}
        for file in self._present():
            if file.name.removesuffix(_PACKED) not in named:
                raise self.error(
                    f"holds {file.name}, which {METADATA} does not name",
                    "`ros2 bag reindex` names all files; move the file away if it is another recording",
                )

    def _open_storages(self, files: list[StoredFile]) -> None:
        from dineros.observation.recordings.files import most_unpacked, unpacked
        from dineros.observation.recordings.storages import opened

        left = most_unpacked(self._bytes)
        for file in files:
            kind = _KINDS.get(file.suffix, "") if self._metadata is None else self._metadata.storage
            with self._guarded(file.path):
                source = file
                if self._metadata is not None and self._metadata.packed == "file":
                    source = self._open.enter_context(unpacked(file, left))
                    left -= source.size
                storage = opened(source, kind)
            self._open.callback(storage.close)
            of_topics = sum(connection.msgcount for connection in storage.connections)
            if of_topics < storage.metadata.message_count:
                raise RecordingError(
                    f"holds {counted(storage.metadata.message_count, 'message')}, "
                    f"but only {of_topics:,} on topics that it describes",
                    location=Location(file.path),
                    hint=_REINDEX,
                )
            self._storages.append((file.path, storage))
        self._storages.sort(key=lambda each: each[1].metadata.start_time)
        for _, storage in self._storages:
            for connection in storage.connections:
                told = self._told[connection.topic]
                told.types.add(connection.msgtype)
                told.by_files += connection.msgcount
                told.offered += getattr(connection.ext, "offered_qos_profiles", ())
        for topic in self._metadata.topics if self._metadata is not None else ():
            told = self._told[topic.name]
            told.by_metadata = (told.by_metadata or 0) + topic.count
            told.types = told.types or {topic.type}
            told.offered = told.offered or topic.offered
        too_many = exceeds("topics", len(self._told), "holds")
        if too_many is not None:
            raise self.error(too_many.message, too_many.hint)

    def _compare_counts(self) -> None:
        """Reject a recording that declares more messages than its files hold.

        Otherwise messages that cannot be read would count as not sent.
        """
        if self._metadata is None:
            return
        for name, told in sorted(self._told.items()):
            self._check_count(name, told.by_metadata or 0, told.by_files)
        found = sum(told.by_files for told in self._told.values())
        if found < self._metadata.count:
            raise self._too_few(f"{counted(self._metadata.count, 'message')}", found)

    def _check_count(self, topic: str, told: int, found: int) -> None:
        if found < told:
            raise self._too_few(f"{counted(told, 'message')} on {topic!r:.300}", found)

    def _too_few(self, told: str, found: int) -> RecordingError:
        return self.error(f"declares {told}, but only {found:,} can be read", _REINDEX)

    def _times(self) -> tuple[int, int]:
        """Return the start and the length of the recording in nanoseconds, according to its files."""
        told = [each for _, storage in self._storages if (each := storage.metadata).message_count]
        start = min((each.start_time for each in told), default=0)
        return start, max((each.end_time for each in told), default=start) - start

    def _topics(self, left_out: list[str]) -> Iterator[RecordedTopic]:
        for name in sorted(self._told):
            why = self._unreadable(name, self._told[name])
            if why is not None:
                left_out.append(f"topic {name!r:.300} {why}")
                continue
            told = self._told[name]
            offered = tuple(quality_of_profile(quality, _seconds) for quality in told.offered)
            yield RecordedTopic(name, next(iter(told.types)), offered, told.messages)

    def _unreadable(self, name: str, told: _RecordedTopic) -> str | None:
        """Return why a topic cannot be read; None if it can."""
        types = sorted(told.types)
        if not _TOPIC.fullmatch(name) or not name.strip("/"):
            return "has a name that is not a valid topic name"
        if len(types) > 1:
            return f"is of several types: {', '.join(map(repr, types)):.300}"
        if not _TYPE.fullmatch(types[0]):
            return f"is of the unknown type {types[0]!r:.100}; a type is like std_msgs/msg/String"
        if full_name(name) != name and full_name(name) in self._told:
            return f"is the same as {full_name(name)} to a model, and both were recorded"
        return None

    def error(self, message: str, hint: str | None = None) -> RecordingError:
        """Return an error about the recording."""
        return RecordingError(message, location=Location(self._path), hint=hint)

    @contextmanager
    def _guarded(self, path: Path) -> Iterator[None]:
        try:
            yield
        except (DinerosError, MemoryError):
            raise
        except Exception as error:  # any error of the library, the database or a decompressor
            if isinstance(error, OSError) and error.strerror:
                raise RecordingError(f"cannot be read: {error.strerror}", location=Location(path)) from error
            said = " ".join(str(error).split()).rstrip(".")
            raise RecordingError(
                f"is damaged or cut off: {said or type(error).__name__:.300}",
                location=Location(path),
                hint=_REINDEX,
            ) from error


def _is_of_events(topic: RecordedTopic) -> bool:
    return topic.name.endswith(OF_EVENTS) and "/srv/" in topic.type and topic.type.endswith(_EVENT)


def _service(topic: RecordedTopic) -> RecordedService:
    return RecordedService(
        topic.name.removesuffix(OF_EVENTS), topic.type.removesuffix(_EVENT), topic.messages
    )


def _seconds(duration: Duration) -> float | None:
    """Return a duration in seconds; None: unbounded, stored as zero or as the largest number."""
    if duration.sec >= _ENDLESS or (not duration.sec and not duration.nsec):
        return None
    return duration.sec + duration.nsec / 1e9
