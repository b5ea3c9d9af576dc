"""What makes the interfaces be built again, and what does not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.generators.templates.rendering import OURS
from dineros.generators.workspace import building
from dineros.metamodel import sym
from tests.generators.models import change_field, kitchen

OPTIONS = Options(source="kitchen.sym.xmi")
Builds = list[Sequence[str]]


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> Builds:
    """What colcon was asked to build; it makes the folders that it would."""
    asked: Builds = []

    def colcon(workspace: Path, arguments: Sequence[str] = ()) -> None:
        asked.append(arguments)
        (workspace / "install/kitchen_interfaces").mkdir(parents=True)

    monkeypatch.setattr(building, "colcon", colcon)
    return asked


def built(model: sym.SystemModel, workspace: Path, options: Options, builds: Builds) -> bool:
    """Tell whether the interfaces are built again."""
    before = len(builds)
    generate(model, workspace, options)
    building.build_interfaces(workspace)
    return len(builds) > before


def test_interfaces_are_built_for_what_they_say_and_for_nothing_else(tmp_path: Path, builds: Builds) -> None:
    model = kitchen()
    assert built(model, tmp_path, OPTIONS, builds)
    assert not built(model, tmp_path, OPTIONS, builds)
    long = tuple(f"Hungry.tokens={number}" for number in range(20))  # over several lines of each file's head
    for options in (
        replace(OPTIONS, settings=long),
        replace(OPTIONS, source="another-name.sym.xmi"),
        replace(OPTIONS, maintainer="Ada <ada@example.org>", license="MIT"),
    ):
        assert not built(model, tmp_path, options, builds)
    model.name = "The kitchen"
    assert not built(model, tmp_path, OPTIONS, builds)

    change_field(model, "table", name="seat")
    assert built(model, tmp_path, OPTIONS, builds)
    template = tmp_path / "templates/interfaces/package.xml.j2"
    template.parent.mkdir(parents=True)
    ours = OURS / "interfaces/package.xml.j2"
    text = ours.read_text(encoding="utf-8")
    template.write_text(text.replace("  <member", "  <depend>geometry_msgs</depend>\n  <member"))
    assert built(model, tmp_path, replace(OPTIONS, templates=template.parents[1]), builds)


def test_what_developers_built_with_colcon_is_used(tmp_path: Path, builds: Builds) -> None:
    generate(kitchen(), tmp_path, OPTIONS)
    (tmp_path / "install/kitchen_interfaces").mkdir(parents=True)
    building.remember(tmp_path)
    building.build_interfaces(tmp_path)
    assert builds == []
