"""Reads the output of the nodes of a run on ROS 2: each has a file next to its trace."""

from __future__ import annotations

import os
from pathlib import Path

from dineros.metamodel.files.reading import open_plain

MOST_BYTES = 64 << 10
"""Limit of the bytes of one node that are read at a time; of more, the last ones."""


class NodeLogs:
    """The logs in a folder, as they grow.

    Parameters
    ----------
    folder : Path
        The folder, which may not exist yet.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._taken: dict[Path, int] = {}

    def new_lines(self) -> list[str]:
        """Return the lines since the last call, each with the name of its node."""
        found = []
        for path in sorted(self._folder.glob("*.log")):
            if path.is_file() and not path.is_symlink():
                found += [f"{path.stem}: {line}" for line in self._lines(path)]
        return found

    def _lines(self, path: Path) -> list[str]:
        with os.fdopen(open_plain(path, follow_links=False), "rb") as log:
            size, begin = log.seek(0, 2), self._taken.get(path, 0)
            left_out = max(0, size - begin - MOST_BYTES)
            log.seek(begin + left_out)
            whole, end, _ = log.read(MOST_BYTES).rpartition(b"\n")
        if not end and not left_out:
            return []  # the line is not at its end yet
        self._taken[path] = begin + left_out + len(whole) + len(end)
        lines = whole.decode("utf-8", "replace").split("\n")
        return [f"… {left_out:,} bytes more", *lines[1:]] if left_out else lines
