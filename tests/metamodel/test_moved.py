"""Former names of modules."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    ("former", "present"),
    [
        ("dineros.transformations.split", "dineros.transformations.flattening.split"),
        ("dineros.transformations.flatten", "dineros.transformations.flattening.flatten"),
        ("dineros.transformations.rule", "dineros.transformations.language.rule"),
        ("dineros.transformations.services", "dineros.transformations.rules.services"),
        ("dineros.analysis.compiled", "dineros.analysis.nets.compiled"),
        ("dineros.analysis.check", "dineros.analysis.checks.check"),
        ("dineros.analysis.questions.check", "dineros.analysis.checks.check"),
        ("dineros.analysis.questions.capacities", "dineros.analysis.suggestions.capacities"),
        ("dineros.analysis.subject", "dineros.analysis.model.subject"),
        ("dineros.analysis.statespace", "dineros.analysis.questions.state_space"),
        ("dineros.analysis.logic.parser", "dineros.analysis.logic.language.parser"),
        ("dineros.analysis.logic.names", "dineros.analysis.logic.language.names"),
        ("dineros.runtime.net", "dineros.runtime.nodes.net"),
        ("dineros.runtime.handlers", "dineros.runtime.firing.handlers"),
        ("dineros.runtime.signals", "dineros.runtime.nets.signals"),
        ("dineros.runtime.transport", "dineros.runtime.channels.transport"),
        ("dineros.runtime.ros.memory", "dineros.runtime.ros.process.memory"),
        ("dineros.cli.commands.check", "dineros.cli.commands.analysis.check"),
        ("dineros.cli.tracing", "dineros.cli.presentation.traces"),
        ("dineros.generators.manifest", "dineros.generators.workspace.manifest"),
        ("dineros.views.nets.model", "dineros.views.nets.contents.model"),
        ("dineros.metamodel.constraints.topics", "dineros.metamodel.constraints.families.topics"),
        ("dineros.metamodel.files.xmi_reader", "dineros.metamodel.files.xmi.reader"),
        ("dineros.metamodel.files.positions", "dineros.metamodel.positions"),
        ("dineros.analysis.logic.budget", "dineros.analysis.answers.budget"),
        ("dineros.analysis.logic.verdicts.answer", "dineros.analysis.answers.outcome"),
    ],
)
def test_a_module_that_moved_is_found_with_a_warning(
    former: str, present: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, former, raising=False)
    with pytest.warns(DeprecationWarning, match=f"{former} is {present} now"):
        assert importlib.import_module(former) is importlib.import_module(present)
    assert importlib.import_module(present).__spec__.name == present  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "name",
    ["dineros.transformations.nowhere", "dineros.transformations.*", "dineros.analysis.kernels"],
)
def test_what_never_was_is_not_found(name: str) -> None:
    with pytest.raises(ModuleNotFoundError, match="No module named"):
        importlib.import_module(name)


def test_the_warning_names_the_line_that_imports() -> None:
    code = "from dineros.transformations.split import split"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.startswith("<string>:1: DeprecationWarning: dineros.transformations.split is ")
