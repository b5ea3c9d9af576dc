"""Build the wheel ``dineros-runtime``: what a robot needs, from the same sources.

Usage: ``tools/runtime_wheel.py [FOLDER]``, by default ``dist``. Which rooms it holds and what they need
is in ``pyproject.toml``, in the table ``tool.dineros.runtime``; all else is as for ``dineros`` itself.
Whoever has ``dineros`` has all of it already: the two are not installed side by side.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
BACKEND = "setuptools.build_meta"


def settings_of(whole: dict[str, Any]) -> dict[str, Any]:
    """Return what ``pyproject.toml`` says of the runtime's wheel, given what it says of the project."""
    project, runtime = whole["project"], whole["tool"]["dineros"]["runtime"]
    extras = {name: project["optional-dependencies"][name] for name in runtime["extras"]}
    own = {
        "name": runtime["name"],
        "description": runtime["description"],
        "license": runtime["license"],
        "license-files": ["LICENSE"],
        "dependencies": [each for each in project["dependencies"] if _name(each) in runtime["needs"]],
        "optional-dependencies": extras,
    }
    taken = ("version", "requires-python", "authors", "classifiers")
    setuptools = whole["tool"]["setuptools"]
    rooms = {f"dineros.{room}": room for room in runtime["rooms"]}
    packages = {"package-dir": rooms, "package-data": setuptools["package-data"]}
    return {
        "build-system": whole["build-system"],
        "project": {**{name: project[name] for name in taken}, **own},
        "tool": {"setuptools": packages},
    }


def _name(requirement: str) -> str:
    return requirement.replace("=", ">").partition(">")[0].strip()


def _toml(settings: dict[str, Any], before: str = "") -> str:
    """Return settings as TOML, tables by their headings."""
    plain = {name: value for name, value in settings.items() if not isinstance(value, dict)}
    text = f"[{before}]\n" if plain and before else ""
    text += "".join(f"{json.dumps(name)} = {_value(value)}\n" for name, value in plain.items())
    for name, value in settings.items():
        if isinstance(value, dict):
            inner = json.dumps(name)
            text += _toml(value, f"{before}.{inner}" if before else inner)
    return text


def _value(value: Any) -> str:
    """Return a value of TOML; texts are written in JSON's way, which is TOML's as well."""
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{json.dumps(name)} = {_value(inner)}' for name, inner in value.items())} }}"
    return json.dumps(value)


def build(folder: Path) -> Path:
    """Build the wheel into a folder, and return its file."""
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    settings = settings_of(whole)
    with tempfile.TemporaryDirectory(prefix="dineros-runtime-") as place:
        copy = Path(place)
        for room in whole["tool"]["dineros"]["runtime"]["rooms"]:
            shutil.copytree(ROOT / room, copy / room, ignore=shutil.ignore_patterns("__pycache__"))
        for file in ("setup.py", "LICENSE"):
            shutil.copy(ROOT / file, copy)
        (copy / "pyproject.toml").write_text(_toml(settings), encoding="utf-8")
        pip = [sys.executable, "-P", "-m", "pip", "--disable-pip-version-check", "--quiet"]
        build = [*pip, "wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", "dist", "."]
        subprocess.run(build, cwd=copy, check=True)
        (built,) = (copy / "dist").glob("*.whl")
        folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(built, folder))


if __name__ == "__main__":
    print(build(Path(sys.argv[1] if len(sys.argv) > 1 else "dist")))
