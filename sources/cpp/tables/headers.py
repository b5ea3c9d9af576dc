"""The headers that files in C++ include; they decide which of several definitions a name means."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePosixPath


class Headers:
    """The headers that the files of a folder include."""

    def __init__(self) -> None:
        self.includes: dict[str, list[str]] = {}
        """The headers that a file names, by its path."""
        self._by_end: dict[str, list[str]] = {}
        self._reached: dict[str, frozenset[str]] = {}

    def add(self, path: str) -> None:
        """Add a file of the folder, before the first question."""
        self._by_end.setdefault(path.rpartition("/")[2], []).append(path)

    def included(self, path: str) -> frozenset[str]:
        """Return a file and the headers of the folder that it includes, also through others."""
        if path not in self._reached:
            todo, seen = [path], {path}
            while todo:
                for each in self.includes.get(todo.pop(), ()):
                    same = self._by_end.get(each.rpartition("/")[2], ())
                    wanted = [one for one in same if f"/{one}".endswith(f"/{each}")]
                    todo += [one for one in wanted if one not in seen]
                    seen.update(wanted)
            self._reached[path] = frozenset(seen)
        return self._reached[path]

    def named(self, header: str, path: str) -> str | None:
        """Return the file of the folder that a file includes as a header; None: it is not in the folder."""
        header = header.replace("../", "").removeprefix("./")
        same = self._by_end.get(header.rpartition("/")[2], ())
        wanted = [each for each in same if f"/{each}".endswith(f"/{header}") and each != path]
        return max(wanted, key=lambda each: _nearness(path, each), default=None)

    def nearest(self, path: str, others: Iterable[str]) -> set[str]:
        """Return which of several files define what a file means: those that it includes, in its folder."""
        found = set(others)
        found = {each for each in found if not self._is_ros_1(each)} or found
        if len(found) > 1:
            found = found & self.included(path) or found
        near = max(_nearness(path, each) for each in found)
        return {each for each in found if _nearness(path, each) == near}

    def _is_ros_1(self, path: str) -> bool:
        """Return whether a file is for ROS 1, such as one next to another for ROS 2."""
        named = self.includes.get(path, ())
        return "ros/ros.h" in named and not any(each.startswith("rclcpp/") for each in named)


def _nearness(one: str, other: str) -> int:
    """Return how many folders two paths have in common."""
    ours, theirs = PurePosixPath(one).parts, PurePosixPath(other).parts
    return next((n for n, (a, b) in enumerate(zip(ours, theirs, strict=False)) if a != b), len(ours))
