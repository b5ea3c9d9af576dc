"""Run mypy over the project.

The import package ``dineros`` has no folder of its own: ``pyproject.toml`` maps each top-level room into it,
which mypy cannot read. So each run first makes links ``build/typed/dineros/<room>``, and names the true files
in what it prints. New files are seen at once, without a new installation.

For the same reason no type checker sees an editable installation. A folder ``dineros-stubs`` beside the
installed packages says where their types are (PEP 561), so that code of others is checked against them.

Usage: ``.venv/bin/python tools/typecheck.py [MYPY-OPTION...]``; ``--link`` alone makes the links only
"""

import os
import shutil
import sys
import sysconfig
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINKS = Path("build/typed")
BESIDE = ["benchmarks", "case_study", "docs", "examples", "tests", "tools"]


def link_rooms(root: Path) -> dict[str, str]:
    """Make the links again.

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


def show_to_others(root: Path, site_packages: Path) -> None:
    """Let type checkers find the rooms from anywhere, as those of an installed wheel; Python does not see it.

    Parameters
    ----------
    root
        The project's root, its links made.
    site_packages
        Folder of the environment that the project is installed in.
    """
    link = site_packages / "dineros-stubs"
    link.unlink(missing_ok=True)
    link.symlink_to(root / LINKS / "dineros", target_is_directory=True)


def main(options: list[str]) -> int:
    """Check all rooms, and the folders next to them that hold Python files.

    Parameters
    ----------
    options
        Options for mypy, or ``--link``.

    Returns
    -------
    int
        Mypy's exit status.
    """
    os.chdir(ROOT)
    rooms = link_rooms(ROOT)
    show_to_others(ROOT, Path(sysconfig.get_path("purelib")))
    if options == ["--link"]:
        return 0
    from mypy import api

    beside = [folder for folder in BESIDE if any(Path(folder).rglob("*.py"))]
    report, errors, status = api.run([*options, *rooms, *beside])
    for link, folder in rooms.items():
        report = report.replace(f"{link}/", f"{folder}/")
    sys.stdout.write(report)
    sys.stderr.write(errors)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
