"""The Makefile's help, and what mypy is shown."""

import os
import re
import subprocess
from pathlib import Path

from tools.typecheck import link_rooms, show_to_others

ROOT = Path(__file__).resolve().parents[2]


def make(*arguments: str) -> list[str]:
    """Lines that make prints, without those that a surrounding `make test` would make it add."""
    of_make = ("MAKE", "MFLAGS", "LINT", "PYTHON", "PYTEST_ARGS")
    bare = {name: value for name, value in os.environ.items() if not name.startswith(of_make)}
    command = ["make", *arguments]
    done = subprocess.run(command, cwd=ROOT, env=bare, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


def test_help_names_every_target() -> None:
    targets = re.findall(r"^\.PHONY: ([a-z]+)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert [line.split()[0] for line in make("help")] == targets
    assert {"install", "demo", "test", "regenerate", "format", "benchmark", "lock", "audit", "clean"} <= set(
        targets
    )


def test_tests_come_last() -> None:
    plan = make("-n", "test")
    assert "-m pytest" in plan[-1]
    steps = ["ruff check", "ruff format", "typecheck.py", "generate --check", "-m pytest"]
    lines = [next(number for number, line in enumerate(plan) if step in line) for step in steps]
    assert lines == sorted(lines)
    alone = make("-n", "test", "LINT=no")
    assert alone[-1] == plan[-1] and not any("ruff" in line or "typecheck.py" in line for line in alone)
    assert "tools/browser-packages" in alone, "tests of pages need axe-core, with lint or without"


def test_links_show_the_rooms_and_forget_old_ones(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text('[tool.setuptools.package-dir]\n"dineros.views" = "views"\n')
    (tmp_path / "views").mkdir()
    old = tmp_path / "build/typed/dineros/gone"
    old.mkdir(parents=True)
    assert link_rooms(tmp_path) == {"build/typed/dineros/views": "views"}
    (tmp_path / "views/new.py").touch()
    assert (tmp_path / "build/typed/dineros/views/new.py").exists()
    assert not old.exists()
    link_rooms(tmp_path)
    assert (tmp_path / "views/new.py").exists(), "links are removed, never what they show"


def test_type_checkers_of_others_see_the_rooms(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text('[tool.setuptools.package-dir]\n"dineros.views" = "views"\n')
    (tmp_path / "views").mkdir()
    (tmp_path / "views/py.typed").touch()
    (tmp_path / "site").mkdir()
    for _ in range(2):  # also where an earlier installation left its link
        link_rooms(tmp_path)
        show_to_others(tmp_path, tmp_path / "site")
        assert (tmp_path / "site/dineros-stubs/views/py.typed").is_file()
