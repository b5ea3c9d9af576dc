"""The wheel holds every module and data file of every room, and works where the source tree is not."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
ROOMS: dict[str, str] = SETTINGS["tool"]["setuptools"]["package-dir"]
ALL_ROOMS = ["metamodel", "transformations", "analysis", "generators", "runtime", "sources", "views", "cli"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build from a copy, so that nothing an earlier build left in the tree can slip in."""
    copy = tmp_path_factory.mktemp("source")
    ignored = shutil.ignore_patterns("__pycache__")
    for room in ROOMS.values():
        shutil.copytree(ROOT / room, copy / room, ignore=ignored)
    for file in ROOT.iterdir():
        if file.is_file():
            shutil.copy(file, copy)
    (copy / "metamodel/__pycache__").mkdir()  # must not become a package
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    build = [*pip, "wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", "dist", "."]
    subprocess.run(build, cwd=copy, check=True, capture_output=True, text=True)
    (built,) = (copy / "dist").glob("dineros-*.whl")
    return built


def test_every_room_that_exists_is_packaged() -> None:
    there = {room for room in ALL_ROOMS if (ROOT / room / "__init__.py").exists()}
    assert there <= set(ROOMS.values()), "add the room to [tool.setuptools.package-dir] in pyproject.toml"
    assert all(package == f"dineros.{room}" for package, room in ROOMS.items())


@pytest.mark.long
def test_wheel_holds_every_file_of_every_room(wheel: Path) -> None:
    inside = set(ZipFile(wheel).namelist())
    expected = {
        f"dineros/{file.relative_to(ROOT).as_posix()}"
        for room in ROOMS.values()
        for file in (ROOT / room).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    packaged = {name for name in inside if name.startswith("dineros/")}
    assert packaged == expected, "add the file's pattern to [tool.setuptools.package-data] in pyproject.toml"
    assert not any("__pycache__" in name for name in inside)


@pytest.mark.parametrize("room", ROOMS.values())
def test_room_is_typed(room: str) -> None:
    assert (ROOT / room / "py.typed").exists(), "type checkers of users would not read its hints"


@pytest.mark.long
def test_wheel_alone_can_be_imported(wheel: Path, tmp_path: Path) -> None:
    ZipFile(wheel).extractall(tmp_path / "site")
    names = ", ".join(ROOMS)
    code = f"import {names}, sys; print(*[sys.modules[name].__file__ for name in sys.argv[1:]], sep='\\n')"
    answer = subprocess.run(
        [sys.executable, "-c", code, *ROOMS],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path / "site")},
        check=True,
        capture_output=True,
        text=True,
    )
    files = answer.stdout.splitlines()
    assert len(files) == len(ROOMS)
    assert all(Path(file).is_relative_to(tmp_path) for file in files)


def test_metadata_names_licence_and_command(wheel: Path) -> None:
    with ZipFile(wheel) as archive:
        (metadata,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        text = archive.read(metadata).decode()
        commands = archive.read(metadata.replace("METADATA", "entry_points.txt")).decode()
    assert "License-Expression: Apache-2.0 AND " in text
    (versions,) = re.findall("^Requires-Python: (.*)$", text, re.MULTILINE)
    supported = SpecifierSet(versions)
    tried = [f"3.{minor}.0" for minor in range(16) if f"3.{minor}.0" in supported]
    named = re.findall(r"^Classifier: .* :: Python :: 3\.(\d+)$", text, re.MULTILINE)
    assert tried == [f"3.{minor}.0" for minor in named] == ["3.11.0", "3.12.0"]
    assert "dineros = dineros.cli.main:main" in commands


def test_licence_expression_names_what_is_inside(wheel: Path) -> None:
    """Ours, and one for each folder of what others made, whose own text is among the licence files."""
    with ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        text = archive.read(metadata).decode()
        about = archive.read("dineros/views/vendor/ABOUT.md").decode()
    bundled = {name.split("/")[3] for name in names if re.match("dineros/views/vendor/[^/]+/", name)}
    licences = dict(
        re.findall(r"^\| `(\w+)/` \|[^|]*\|[^|]*\| ([\w.-]+(?: AND [\w.-]+)*)", about, re.MULTILINE)
    )
    assert set(licences) == bundled, (
        "views/vendor/ABOUT.md names each folder and the SPDX name of its licence"
    )
    (expression,) = re.findall("^License-Expression: (.*)$", text, re.MULTILINE)
    assert expression.split(" AND ") == [
        "Apache-2.0",
        *sorted({one for found in licences.values() for one in found.split(" AND ")}),
    ]
    files = set(re.findall("^License-File: (.*)$", text, re.MULTILINE))
    assert {Path(file).parent.as_posix() for file in files} == {
        ".",
        *(f"views/vendor/{each}" for each in bundled),
    }
    assert all(f"{Path(metadata).parent}/licenses/{file}" in names for file in files)


def test_what_others_made_lies_in_the_vendor_folder(wheel: Path) -> None:
    """Minified scripts, fonts, archives and notices of other holders of rights stand nowhere else."""
    foreign = re.compile(
        rb"SPDX-License|Copyright \(c\)|Copyright [12]|@licen[cs]e|\(c\) (19|20)\d\d", re.IGNORECASE
    )
    with ZipFile(wheel) as archive:
        for name in archive.namelist():
            if not name.startswith("dineros/") or name.startswith("dineros/views/vendor/"):
                continue
            assert Path(name).suffix not in {".ttf", ".otf", ".woff", ".woff2", ".jar", ".so", ".wasm"}, name
            content = archive.read(name)
            assert max(map(len, content.splitlines()), default=0) < 2000, f"{name} looks minified"
            assert not foreign.search(content), name
