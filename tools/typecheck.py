"""Run mypy over the project.

The import package ``dineros`` has no folder of its own: ``pyproject.toml`` maps each top-level room into it,
which mypy cannot read. So each run first makes links ``build/typed/dineros/<room>``, and names the true files
in what it prints. New files are seen at once, without a new installation.

Usage: ``.venv/bin/python tools/typecheck.py [MYPY-OPTION...]``
"""

import os
import shutil
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINKS = Path("build/typed")
BESIDE = ["benchmarks", "case_study", "docs", "tests", "tools"]


def link_rooms(root: Path) -> dict[str, str]:
    """Make the links anew.

    Parameters
    ----------
    root
        The project's root, with its ``pyproject.toml``.

    Returns
    -------
    dict
        From each link to the room it shows, both as paths from the root.
    """
    settings = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    rooms = {}
    shutil.rmtree(root / LINKS, ignore_errors=True)
    for package, folder in settings["tool"]["setuptools"]["package-dir"].items():
        link = root / LINKS / package.replace(".", "/")
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(os.path.relpath(root / folder, link.parent), target_is_directory=True)
        rooms[link.relative_to(root).as_posix()] = folder
    return rooms


def main(options: list[str]) -> int:
    """Check all rooms, and the folders beside them that hold Python files.

    Parameters
    ----------
    options
        Options for mypy.

    Returns
    -------
    int
        Mypy's exit status.
    """
    from mypy import api

    os.chdir(ROOT)
    rooms = link_rooms(ROOT)
    beside = [folder for folder in BESIDE if any(Path(folder).rglob("*.py"))]
    report, errors, status = api.run([*options, *rooms, *beside])
    for link, folder in rooms.items():
        report = report.replace(f"{link}/", f"{folder}/")
    sys.stdout.write(report)
    sys.stderr.write(errors)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
