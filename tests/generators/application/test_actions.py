"""Actions in generated workspaces: interface files, packages, READMEs and stubs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.generators.application.interfaces import interfaces_of
from dineros.generators.application.naming import NamingError
from dineros.metamodel import sym
from tests.runtime.ros.errands import errands


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("workspace")
    generate(errands(), folder, Options(source="errands.sym.xmi"))
    return folder


def test_an_action_without_a_type_gets_one(workspace: Path) -> None:
    package = workspace / "src/errands_interfaces"
    lines = (package / "action/Errand.action").read_text().splitlines()
    assert [line for line in lines if line and not line.startswith("#")] == [
        "Job token", "---", "Job token", "---", "Job token", "int64 number"
    ]  # fmt: skip
    assert [path.name for path in (package / "action").iterdir()] == ["Errand.action"]
    assert '"action/Errand.action"' in (package / "CMakeLists.txt").read_text()
    assert "<depend>action_msgs</depend>" in (package / "package.xml").read_text()


def test_readme_and_stubs_speak_of_slots(workspace: Path) -> None:
    readme = (workspace / "src/runner/README.md").read_text()
    assert "## Topics, services and actions" in readme
    assert "| action server | `/errand` | `errands_interfaces/action/Errand` | `AskedErrand` |" in readme
    assert "cancel StopErrand, feedback ToldErrand, 2 slots" in readme
    assert "1 slot, may refuse" in readme
    stubs = (workspace / "src/runner/runner/handlers.py").read_text()
    assert "For each of the 2 instances of Errand" in stubs
    boss = (workspace / "src/boss/README.md").read_text()
    assert "| action client | `/errand` |" in boss
    assert "succeeded FineErrand, aborted FailedErrand" in boss


def test_an_action_without_results_and_feedback() -> None:
    model = errands()
    for channel in model.channels:
        assert isinstance(channel, sym.ActionChannel)
        channel.server.feedback = channel.server.aborted = None
        channel.server.succeeded = channel.server.canceled = None
    (action,) = interfaces_of(model).actions
    assert (action.result, action.feedback) == (None, None)


def test_two_actions_of_one_name_are_refused() -> None:
    model = errands()
    model.channels[1].type = None
    model.channels[1].id = "errand"
    with pytest.raises(NamingError, match="actions 'Errand' and 'errand' both become the type"):
        interfaces_of(model)
