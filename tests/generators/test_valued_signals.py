"""Packages of nodes whose signals have values: what they say of them, and their tests."""

from __future__ import annotations

from pathlib import Path

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step


def test_values_stand_in_documents_parameters_and_cases(tmp_path: Path) -> None:
    model = sym.SystemModel(id="machine")
    node = node_net(model, "mill", {"Door": (), "Mode": ["idle", "on", "broken"]})
    ready = place(node, "Ready", tokens=1)
    step(node, "Mill", [ready], [place(node, "Done")], clause="!Door & Mode = 'on'")
    generate(model, tmp_path, Options(source="machine.sym.xmi"))
    package = tmp_path / "src" / "mill"
    readme = (package / "README.md").read_text()
    assert "\n\n* `Mode`: `idle`, `on`, `broken`\n\n| signal |" in readme
    assert "| `Mode` | idle |" in readme
    (parameters,) = (tmp_path / "src").glob("*/config/mill.yaml")
    assert "      Mode: idle\n" in parameters.read_text()
    test = (package / "test" / "test_mill.py").read_text()
    assert "signals: dict[str, bool | str]" in test and '"Mode": "on",' in test
