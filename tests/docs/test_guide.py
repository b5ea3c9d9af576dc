"""The guide: diagrams show every class, the reference every command, nothing comes from elsewhere."""

from __future__ import annotations

import html
import importlib
import importlib.util
import inspect
import itertools
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

from dineros.metamodel.constraints import validate
from dineros.metamodel.files import load
from dineros.metamodel.settings import apply
from tests.support.programs.system_packages import needs
from tests.views.axe import faults

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ROOT = Path(__file__).resolve().parents[2]


def hook(name: str) -> ModuleType:
    """Import a hook of the guide, which is not a package."""
    specification = importlib.util.spec_from_file_location(f"hook_{name}", ROOT / "docs/hooks" / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_every_class_and_enumeration_stands_in_a_diagram() -> None:
    diagrams = hook("class_diagrams")
    for name, package in diagrams.read_metamodels().items():
        shown = {member for _, members in diagrams.parts_of(name, package).values() for member in members}
        assert shown == {classifier.name for classifier in package.eClassifiers}


def test_every_feature_stands_in_a_diagram() -> None:
    diagrams = hook("class_diagrams")
    for name, package in diagrams.read_metamodels().items():
        text = "".join(diagrams.to_dot(package, *part) for part in diagrams.parts_of(name, package).values())
        for classifier in package.eClassifiers:
            for feature in getattr(classifier, "eStructuralFeatures", []):
                opposite = getattr(feature, "eOpposite", None)
                names = {feature.name, opposite.name if opposite else feature.name}
                assert any(f"{known} " in text or f"{known}:" in text for known in names), feature.name


def test_every_setting_of_the_page_applies() -> None:
    page = (ROOT / "docs/settings.md").read_text(encoding="utf-8")
    settings = [
        text.strip("'")
        for row in re.findall(r"^\| (`.+?) \|", page, flags=re.MULTILINE)
        for text in re.findall(r"`(.+?)`", row)
    ]
    model = load(ROOT / "case_study/sorting.sym.xmi")
    assert len(settings) > 10
    for setting in settings:
        apply(model, setting)
    assert [violation for violation in validate(model) if violation.severity == "error"] == []


def test_the_reference_holds_every_command() -> None:
    reference = hook("command_line").reference()
    for command in ("completion", "convert", "validate"):
        assert f"## dineros {command}\n" in reference
        assert f"Usage: dineros {command}" in reference


def test_the_reference_holds_every_class_with_what_its_docstring_says() -> None:
    reference = hook("class_reference")
    page = reference.page()
    for name in reference.MODULES:
        found = reference.members(importlib.import_module(name))
        assert found, name
        for member, value in found:
            assert f"### {member} {{ #{name}.{member} }}\n" in page
            assert reference.documented(inspect.getdoc(value)) in page
    assert "* `tokens` (`int`): " in page
    assert "Net.handler(transition, *, " in page
    assert "\nArc(*, page=..., " in page


def test_docstrings_become_markdown() -> None:
    parameters = "Parameters\n----------\nid : str\n    Its ``id``,\n    or none."
    text = f"Do *it*.\n\n{parameters}\n\nRaises\n------\nOSError\n    It fails."
    assert hook("class_reference").documented(text) == (
        "Do \\*it\\*.\n\n**Parameters**\n\n* `id` (`str`): Its `id`, or none."
        "\n\n**Raises**\n\n* `OSError`: It fails."
    )


@needs("graphviz")
def test_the_diagrams_are_laid_out() -> None:
    pictures = hook("class_diagrams").pictures()
    assert set(pictures) >= {"class-pn-net", "class-sym-channels", "class-rtm", "class-pnm", "class-trace"}
    assert all(picture.rstrip().endswith("</svg>") for picture in pictures.values())


def test_a_missing_graphviz_leaves_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert "Graphviz" in hook("class_diagrams").to_svg("digraph {}")


def test_the_architecture_picture_shows_what_its_source_says() -> None:
    pictures = ROOT / "docs/pictures"
    source = (pictures / "architecture.dot").read_text(encoding="utf-8")
    picture = html.unescape((pictures / "architecture.svg").read_text(encoding="utf-8"))
    for label in re.findall(r'label="([^"]+)"', source):
        for line in label.split("\\n"):
            assert f">{line}<" in picture


def test_the_front_page_shows_the_whole_chain() -> None:
    page = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    steps = ("Model", "Rules", "Proof", "Packages", "Running nodes", "Traces and conformance")
    for number, step in enumerate(steps, 1):
        assert f"\n{number}. **{step}.**" in page
    for name in ("finding", "net", "run"):
        assert f"](pictures/screenshot-{name}.png)" in page
        assert (ROOT / f"docs/pictures/screenshot-{name}.png").read_bytes().startswith(b"\x89PNG")
    picture = (ROOT / "docs/pictures/architecture.dot").read_text(encoding="utf-8")
    for command in ("flatten", "check, verify", "generate", "run", "conform"):
        assert f"dineros {command}" in picture
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    groups = re.findall(r"^  - (\w+):$", navigation.partition("\nnav:\n")[2], re.MULTILINE)
    assert groups == ["Start", "Model", "Check", "Run", "Look", "Reference"]


def test_nothing_advises_to_clean_the_shared_memory_of_running_systems() -> None:
    rooms = ("cli", "runtime", "generators", "views", "docs", "examples", "case_study")
    paths = [ROOT / "README.md", *(path for room in rooms for path in sorted((ROOT / room).rglob("*.*")))]
    named = {
        path.relative_to(ROOT).as_posix()
        for path in paths
        if path.suffix in (".md", ".py", ".j2") and "shm clean" in path.read_text(encoding="utf-8")
    }
    assert named == {"docs/ros2.md", "runtime/ros/process/memory.py"}  # which say why not
    assert "Do not run Fast DDS's own `fastdds shm clean`" in (ROOT / "docs/ros2.md").read_text("utf-8")


@pytest.mark.long
def test_the_guide_builds_and_loads_nothing_from_elsewhere(tmp_path: Path, browser: Browser) -> None:
    # Not --quiet: it keeps --strict from seeing the warnings.
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    result = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    pages = list(tmp_path.rglob("*.html"))
    assert len(pages) >= 9
    for page in pages:
        loaded = re.findall(
            r'<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)="([^"]+)"', page.read_text("utf-8")
        )
        assert [address for address in loaded if re.match(r"(?:https?:)?//", address)] == []
    for scheme, name in itertools.product(("light", "dark"), ("views", "rules/services", "metamodels")):
        tab = browser.new_page(color_scheme=scheme)  # type: ignore[arg-type]
        tab.goto((tmp_path / f"{name}.html").as_uri())
        assert faults(tab) == [], (scheme, name)
        tab.close()
