"""The contest's nets as they are kept: an archive each, made by others."""

from __future__ import annotations

import tarfile
from pathlib import Path
from typing import Any


def unpack(archive: Path, folder: Path) -> None:
    """Unpack plain files and folders of an archive into a folder, and nothing outside of it.

    Raises
    ------
    tarfile.TarError
        It is damaged, or a name in it leads elsewhere.
    """
    # Python itself looks for such names from 3.11.4 on.
    options: dict[str, Any] = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
    with tarfile.open(archive) as files:
        members = [member for member in files if member.isfile() or member.isdir()]
        for member in members:
            if not (folder / member.name).resolve().is_relative_to(folder.resolve()):
                raise tarfile.ReadError(f"{archive}: {member.name!r} leads out of it")
        files.extractall(folder, members, **options)
