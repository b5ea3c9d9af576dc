"""A generated application in which the data of tokens decides, run in one process and on ROS 2."""

from __future__ import annotations

import importlib
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, read, step
from dineros.metamodel.records import Fire, Header, Record, read_trace, traces_of_runs, write_records
from dineros.runtime.application.simulation import LocalApplication
from dineros.transformations.flattening.split import split
from tests.support.programs.on_ros import build_as_before, on_ros
from tests.support.type_checker import strict_mypy

WORK = '''
@firings.on("Work")
def work(firing: firings.WorkFiring) -> firings.Outcome:
    """Say no once, then yes."""
    tries: int = firing.memory.get("tries", 0)
    firing.memory["tries"] = tries + 1
    return {"state": tokens.ANSWER_ACTIVE if tries else tokens.ANSWER_INACTIVE, "success": tries > 0}
'''


def spawning() -> sym.SystemModel:
    """Return a client that asks until the answer is yes, as far as its tries and mode allow."""
    answer = sym.TokenType(
        id="Answer",
        fields=[
            sym.TokenField(name="success", kind="boolean"),
            sym.TokenField(
                name="state", kind="integer", ros="uint8", values="INACTIVE=0, ACTIVE=1, BROKEN=2"
            ),
            sym.TokenField(name="tries", kind="integer", ros="uint8", minimum=0, maximum=3),
        ],
    )
    model = sym.SystemModel(id="spawning", tokenType=answer, middleware="ros2")
    spawner, manager = node_net(model, "guarded_spawner"), node_net(model, "guarded_manager")
    start, ask, got = place(spawner, "Start", tokens=1), place(spawner, "Ask"), place(spawner, "Got")
    mode, done, lost = place(spawner, "Mode", tokens=1), place(spawner, "Done"), place(spawner, "Lost")
    step(spawner, "First", [start], [ask])
    finish = step(spawner, "Finish", [got], [done])
    finish.guard = "Got.success = true and Mode.state <> 'BROKEN'"
    finish.assigns = "Done.tries := 2, Done.state := Got.state"
    read(mode, finish)
    step(spawner, "Again", [got], [ask]).guard = "success = false and state <> 'BROKEN'"
    step(spawner, "GiveUp", [got], [lost]).guard = "state = 'BROKEN' and tries between 2 and 3"
    page = callback(manager, "Configure", "server")
    entry, exit_ = place(page, "Entry"), place(page, "Exit")
    step(page, "Work", [entry], [exit_])
    model.channels.append(
        sym.ServiceChannel(
            id="ConfigureService",
            service="/configure",
            server=sym.ServerPort(page=page, entry=entry, exit=exit_),
            clients=[sym.ClientPort(client="spawner", request=ask, response=got)],
        )
    )
    return model


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("guarded") / "ws"
    generate(spawning(), folder, Options(source="spawning.sym.xmi"))
    file = folder / "src/guarded_manager/guarded_manager/handlers.py"
    head = file.read_text().partition("@firings.on")[0]
    file.write_text(head.replace("import firings", "import firings, tokens") + WORK.lstrip())
    return folder


def test_stubs_and_tokens_say_what_the_model_says(workspace: Path) -> None:
    stubs = (workspace / "src/guarded_spawner/guarded_spawner/handlers.py").read_text()
    assert "    If Got.success = true and Mode.state <> 'BROKEN'.\n" in stubs
    assert "    It assigns Done.tries := 2, Done.state := Got.state.\n" in stubs
    text = (workspace / "src/guarded_spawner/guarded_spawner/tokens.py").read_text()
    assert '    state: Literal[0, 1, 2]\n    """INACTIVE=0, ACTIVE=1, BROKEN=2."""\n' in text
    assert '    tries: int\n    """0 to 3."""\n' in text
    assert "ANSWER_BROKEN: Final = 2\n" in text


def test_the_generated_tests_fire_guarded_transitions(workspace: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test"],
        cwd=workspace / "src/guarded_spawner",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "4 passed" in done.stdout


@pytest.mark.long
def test_values_that_an_enumeration_does_not_have_are_refused_by_types(workspace: Path) -> None:
    assert "Success" in strict_mypy(workspace, "src/guarded_manager")
    handlers = workspace / "src/guarded_manager/guarded_manager/handlers.py"
    good = handlers.read_text()
    try:
        handlers.write_text(good.replace("tokens.ANSWER_INACTIVE", "7"))
        assert "error:" in strict_mypy(workspace, "src/guarded_manager/guarded_manager/handlers.py")
    finally:
        handlers.write_text(good)


def test_runs_in_one_process(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    application = LocalApplication(split(spawning()), seed=1)
    for node in ("guarded_spawner", "guarded_manager"):
        monkeypatch.syspath_prepend(workspace / "src" / node)
        importlib.import_module(f"{node}.base").register(application.nets[node])
    with application:
        application.run(lambda app: app.count("guarded_spawner", "Done") == 1, 60)
        spawner = application.nets["guarded_spawner"].inspect()
    assert not spawner.errors
    (token,) = spawner.marking["Done"]
    assert token.data == {"success": True, "state": 1, "tries": 2}


@pytest.mark.long
def test_runs_on_ros_as_the_model_says(workspace: Path, tmp_path: Path) -> None:
    with on_ros() as domain:
        build_as_before(workspace)
        command = [sys.executable, "-m", "dineros.cli.main", "run", str(workspace), "--trace", str(tmp_path)]
        command += ["--until", "Done >= 1", "--timeout", "120", "--domain", str(domain), "--reach", "memory"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = traces_of_runs([tmp_path])
    verdict = conform(spawning(), {node: partial(read_trace, files) for node, files in found.items()})
    assert verdict.status == "conforms"
    fired = [r.transition for r in read_trace(found["guarded_spawner"]) if isinstance(r, Fire)]
    assert fired == ["First", "Again", "Finish"]


def test_a_test_made_of_a_trace_is_refused(tmp_path: Path) -> None:
    from dineros.generators.application.collecting import application_of
    from dineros.generators.workspace.scripts import read_script
    from dineros.generators.workspace.steps import ScriptError

    records: list[Record] = [Header(sequence=0, kind="witness", model="spawning")]
    write_records(tmp_path / "witness.jsonl", records)
    with pytest.raises(ScriptError, match="would lack the data of tokens"):
        read_script(tmp_path / "witness.jsonl", application_of(spawning()))
