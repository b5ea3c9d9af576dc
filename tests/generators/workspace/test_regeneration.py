"""A developer's life with a generated workspace: nothing handwritten is lost, and what is stale is named."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from dineros.generators import (
    Comparison,
    EditedError,
    Options,
    WorkspaceError,
    check,
    generate,
    read_manifest,
)
from dineros.generators.workspace.developers import DeveloperFileError
from dineros.generators.workspace.manifest import PLACE, ManifestError
from dineros.generators.workspace.system_model import system_model_of
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.settings import apply
from tests.generators.models import add_transition, change_field, kitchen, remove_transition, rename_node

WAITER = "src/waiter/waiter/handlers.py"
OPTIONS = Options(source="kitchen.sym.xmi")
HANDWRITTEN = '''\
"""My handlers."""

from . import firings


def configure(net):
    pass


@firings.on("TOrder")
def take_order(firing):
    firing.data["isHot"] = True
    return {"guest": "Ada"}


@firings.on("TServe", priority=3)
def serve(firing):
    return {"prices": [1.0, 2.0]}
'''


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Return the workspace of the unchanged model, with handwritten handlers."""
    folder = tmp_path / "ws"
    generate(kitchen(), folder, OPTIONS)
    (folder / WAITER).write_text(HANDWRITTEN, encoding="utf-8")
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def changed(comparison: Comparison, *kinds: str) -> dict[str, str]:
    return {change.path: change.detail for change in comparison.changes if not kinds or change.what in kinds}


def notices(comparison: Comparison) -> list[str]:
    return [str(notice) for notice in comparison.notices]


def is_fine(folder: Path, model: sym.SystemModel) -> bool:
    found = check(model, folder, OPTIONS)
    return not found.changes and not found.edits and not any(notice.stays for notice in found.notices)


def test_the_same_model_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        generate(kitchen(), tmp_path / name, OPTIONS)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert PLACE in contents(tmp_path / "a")


def test_a_second_time_writes_nothing(workspace: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in workspace.rglob("*")}
    assert generate(kitchen(), workspace, OPTIONS).changes == ()
    assert {path: path.stat().st_mtime_ns for path in workspace.rglob("*")} == before
    assert is_fine(workspace, kitchen())


def test_another_name_of_the_models_file_rewrites_the_manifest_alone(workspace: Path) -> None:
    before = contents(workspace)
    renamed = generate(kitchen(), workspace, Options(source="cooking.pnml"))
    assert renamed.changes == ()
    after = contents(workspace)
    assert [path for path in after if after[path] != before.get(path)] == [PLACE]


def test_the_workspace_holds_its_system_model_as_it_was_changed(workspace: Path) -> None:
    model = kitchen()
    apply(model, "Hungry.tokens=7")
    generate(model, workspace, OPTIONS)
    assert find(system_model_of(workspace), "Hungry", sym.Place).tokens == 7
    path = workspace / "src/kitchen_bringup/model/kitchen.sym.xmi"
    path.write_bytes(path.read_bytes().replace(b'tokens="7"', b'tokens="8"'))
    with pytest.raises(
        WorkspaceError, match="was edited, so it differs from the model from which the nodes were generated"
    ):
        system_model_of(workspace)
    path.unlink()
    path.symlink_to("/etc/passwd")
    with pytest.raises(ModelFileError, match="symbolic link"):
        system_model_of(workspace)
    path.unlink()
    with pytest.raises(WorkspaceError, match="does not hold its system model"):
        system_model_of(workspace)


def test_checking_an_empty_folder_names_every_file_and_writes_none(tmp_path: Path) -> None:
    found = check(kitchen(), tmp_path / "ws", OPTIONS)
    assert not (tmp_path / "ws").exists()
    generate(kitchen(), tmp_path / "ws", OPTIONS)
    assert set(changed(found, "new")) == set(contents(tmp_path / "ws")) - {PLACE}


def test_handwritten_code_is_no_edit(workspace: Path) -> None:
    assert is_fine(workspace, kitchen())
    assert (workspace / WAITER).read_text() == HANDWRITTEN


def test_a_new_transition_gets_a_stub_at_the_end(workspace: Path) -> None:
    model = kitchen()
    add_transition(model)
    stale = check(model, workspace, OPTIONS)
    assert changed(stale, "extended") == {WAITER: "stub for TPay"}
    assert "src/waiter/waiter/firings.py" in changed(stale, "changed")
    others = [path for path in changed(stale) if path.startswith(("src/board", "src/kitchen_"))]
    assert others == ["src/kitchen_bringup/model/kitchen.sym.xmi"]
    assert (workspace / WAITER).read_text() == HANDWRITTEN

    generate(model, workspace, OPTIONS)
    text = (workspace / WAITER).read_text()
    assert text.startswith(HANDWRITTEN)
    (stub,) = ast.parse(text.removeprefix(HANDWRITTEN)).body
    assert isinstance(stub, ast.FunctionDef)
    assert (stub.name, ast.unparse(stub.decorator_list[0])) == ("t_pay", "firings.on('TPay')")
    assert is_fine(workspace, model)


def test_a_stub_that_was_removed_stays_removed(workspace: Path) -> None:
    (workspace / WAITER).write_text('"""No handlers at all."""\n', encoding="utf-8")
    assert is_fine(workspace, kitchen())
    model = kitchen()
    add_transition(model)
    generate(model, workspace, OPTIONS)
    assert (
        (workspace / WAITER)
        .read_text()
        .startswith(
            '"""No handlers at all."""\n\n\nfrom . import firings  # noqa: E402\n\n\n@firings.on("TPay")\n'
        )
    )
    (workspace / WAITER).write_text("", encoding="utf-8")
    assert is_fine(workspace, model)


def test_a_stub_takes_no_name_that_is_taken(workspace: Path) -> None:
    (workspace / WAITER).write_text(f"{HANDWRITTEN}\nt_pay = 1\n", encoding="utf-8")
    model = kitchen()
    add_transition(model)
    generate(model, workspace, OPTIONS)
    assert "\ndef t_pay_(firing" in (workspace / WAITER).read_text()


def test_a_transition_that_has_a_handler_already_gets_no_stub(workspace: Path) -> None:
    mine = f'{HANDWRITTEN}\n\n@firings.on("TPay")\ndef pay(firing):\n    return {{}}\n'
    (workspace / WAITER).write_text(mine, encoding="utf-8")
    model = kitchen()
    add_transition(model)
    assert changed(generate(model, workspace, OPTIONS), "extended") == {}
    assert (workspace / WAITER).read_text() == mine


def test_a_handler_of_a_removed_transition_is_reported_until_it_goes(workspace: Path) -> None:
    model = kitchen()
    remove_transition(model, "TServe")
    said = (
        f"{WAITER}:16: handles TServe, which is no longer a transition of waiter "
        "(move its code or remove it) [obsolete-handler]"
    )
    assert said in notices(check(model, workspace, OPTIONS))
    assert said in notices(generate(model, workspace, OPTIONS))
    assert (workspace / WAITER).read_text() == HANDWRITTEN
    assert not is_fine(workspace, model)
    (workspace / WAITER).write_text(HANDWRITTEN[: HANDWRITTEN.index('@firings.on("TServe"')])
    assert is_fine(workspace, model)


def test_a_renamed_transition_is_a_near_match(workspace: Path) -> None:
    model = kitchen()
    find(model, "TServe").id = "TServeDish"
    found = notices(generate(model, workspace, OPTIONS))
    assert any("(did you mean 'TServeDish'?) [obsolete-handler]" in notice for notice in found)
    assert "t_serve_dish" in (workspace / WAITER).read_text()


def test_fewer_instances_make_the_handler_of_one_obsolete(workspace: Path) -> None:
    cook = workspace / "src/kitchen_cook/kitchen_cook/handlers.py"
    cook.write_text(cook.read_text().replace('on("TCook")', 'on("Cook[2].TCook")'), encoding="utf-8")
    assert is_fine(workspace, kitchen())
    model = kitchen()
    find(model, "Cook", sym.ServiceChannel).instances = 1
    found = notices(generate(model, workspace, OPTIONS))
    assert any("handles Cook[2].TCook, but the service has 1 instance (" in notice for notice in found)


def test_changed_fields_are_reported_where_handlers_name_them(workspace: Path) -> None:
    model = kitchen()
    change_field(model, "prices", length=None)
    change_field(model, "isHot", name="isWarm")
    change_field(model, "table", kind="number")
    said = [
        f"{WAITER}:12: take_order handles TOrder: the token field 'isHot' (boolean) no longer exists "
        "[token-changed]",
        f"{WAITER}:18: serve handles TServe: the token field 'prices' was a list of 2 number and is now a "
        "list of number [token-changed]",
        "kitchen.sym.xmi: the token field 'table' was an integer and is now a number; no handler names it "
        "[token-changed]",
    ]
    assert notices(check(model, workspace, OPTIONS)) == said
    assert notices(generate(model, workspace, OPTIONS)) == said
    assert (workspace / WAITER).read_text() == HANDWRITTEN
    assert "bool is_warm" in (workspace / "src/kitchen_interfaces/msg/Meal.msg").read_text()
    assert is_fine(workspace, model)


def test_changed_arcs_are_reported_at_the_handler(workspace: Path) -> None:
    model = kitchen()
    waiter = find(model, "waiter", sym.NodeNet)
    menu = sym.Place(id="Menu", tokens=1, page=waiter)
    flow(menu, find(model, "TOrder", pn.Transition), menu)
    assert notices(generate(model, workspace, OPTIONS)) == [
        f"{WAITER}:10: handles TOrder, which was Hungry -> Wanted and is now "
        "Hungry + Menu -> Wanted + Menu [arcs-changed]"
    ]
    assert is_fine(workspace, model)


def test_a_renamed_node_leaves_its_developers_files(workspace: Path) -> None:
    model = kitchen()
    rename_node(model, "waiter", "head_waiter")
    comparison = generate(model, workspace, OPTIONS)
    new = "src/head_waiter/head_waiter/handlers.py"
    said = (
        f"{WAITER}: belongs to waiter, which the model no longer has; file kept "
        f"(if waiter is head_waiter now, move it: git mv -f {WAITER} {new}) [left-over]"
    )
    assert said in notices(comparison)
    left = [path for path in contents(workspace) if path.startswith("src/waiter/")]
    assert left == [WAITER]
    assert (workspace / WAITER).read_text() == HANDWRITTEN
    assert not is_fine(workspace, model)
    (workspace / WAITER).rename(workspace / new)
    (workspace / "src/waiter/waiter").rmdir()
    assert generate(model, workspace, OPTIONS).notices == ()
    assert is_fine(workspace, model)
    assert (workspace / new).read_text() == HANDWRITTEN


def test_a_removed_node_that_nobody_wrote_for_goes_without_a_trace(workspace: Path) -> None:
    model = kitchen()
    rename_node(model, "board", "screen")
    (workspace / "src/board/board/__pycache__").mkdir()
    generate(model, workspace, OPTIONS)
    assert not (workspace / "src/board").exists()
    assert is_fine(workspace, model)


def test_an_edited_file_is_refused_with_its_difference(workspace: Path) -> None:
    base = workspace / "src/waiter/waiter/base.py"
    base.write_text(base.read_text().replace('NODE = "waiter"', 'NODE = "mine"'), encoding="utf-8")
    model = kitchen()
    add_transition(model)
    before = contents(workspace)
    with pytest.raises(EditedError) as error:
        generate(model, workspace, OPTIONS)
    assert contents(workspace) == before
    (edit,) = error.value.edits
    assert edit.path == "src/waiter/waiter/base.py"
    assert '\n-NODE = "waiter"\n+NODE = "mine"\n' in edit.difference
    assert str(error.value).startswith(f"{base}: was edited: nothing is written (move your change")
    assert [edit.path for edit in check(model, workspace, OPTIONS).edits] == ["src/waiter/waiter/base.py"]


def test_a_file_that_was_there_before_is_not_overwritten(tmp_path: Path) -> None:
    mine = tmp_path / "src/waiter/setup.py"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine\n")
    with pytest.raises(EditedError, match="already exists, and DiNeROS did not write it"):
        generate(kitchen(), tmp_path, OPTIONS)
    assert list(contents(tmp_path)) == ["src/waiter/setup.py"]


def test_handlers_that_were_there_before_are_kept(tmp_path: Path) -> None:
    mine = tmp_path / WAITER
    mine.parent.mkdir(parents=True)
    mine.write_text(HANDWRITTEN[: HANDWRITTEN.index('@firings.on("TServe"')])
    comparison = generate(kitchen(), tmp_path, OPTIONS)
    assert changed(comparison, "extended") == {WAITER: "stub for TServe"}
    assert mine.read_text().startswith(HANDWRITTEN[: HANDWRITTEN.index('@firings.on("TServe"')])


def test_an_edited_file_that_is_generated_no_longer_stays(workspace: Path) -> None:
    readme = workspace / "src/waiter/README.md"
    readme.write_text("Mine.\n")
    model = kitchen()
    rename_node(model, "waiter", "head_waiter")
    found = notices(generate(model, workspace, OPTIONS))
    assert any(
        notice.startswith("src/waiter/README.md: is not generated any more, but was edited")
        for notice in found
    )
    assert readme.read_text() == "Mine.\n"


def test_a_generated_file_that_is_gone_comes_back(workspace: Path) -> None:
    manifest = (workspace / PLACE).read_bytes()
    (workspace / "src/waiter/setup.py").unlink()
    assert changed(check(kitchen(), workspace, OPTIONS)) == {"src/waiter/setup.py": ""}
    assert changed(generate(kitchen(), workspace, OPTIONS), "restored") == {"src/waiter/setup.py": ""}
    assert is_fine(workspace, kitchen())
    assert (workspace / PLACE).read_bytes() == manifest, "all that was to be written is written"


def test_handlers_that_are_no_python_stop_everything(workspace: Path) -> None:
    (workspace / WAITER).write_text("def broken(:\n")
    model = kitchen()
    add_transition(model)
    before = contents(workspace)
    for work in (generate, check):
        with pytest.raises(DeveloperFileError, match=r"handlers.py:1: is not Python"):
            work(model, workspace, OPTIONS)
    assert contents(workspace) == before


@pytest.mark.long
@pytest.mark.parametrize("written", [0, 1, 7])
def test_a_new_workspace_is_whole_or_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: int
) -> None:
    left = [written]

    def fsync(_: int) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr("dineros.metamodel.files.atomic.os.fsync", fsync)
    with pytest.raises(ModelFileError, match="No space left on device") as caught:
        generate(kitchen(), tmp_path / "a" / "new", OPTIONS)
    assert str(caught.value).startswith(str(tmp_path / "a" / "new" / ""))
    assert list(tmp_path.iterdir()) == []


def test_a_crash_at_any_file_is_fixed_by_the_next_run(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = kitchen()
    add_transition(model)
    change_field(model, "isHot", name="isWarm")
    real = ConfinedFolder.write
    number = len(check(model, workspace, OPTIONS).changes)
    assert number > 5
    for crash_at in (0, 1, number // 2, number - 1):
        left = [crash_at]

        def write(folder: ConfinedFolder, path: str, content: bytes, left: list[int] = left) -> None:
            if path == PLACE:
                return real(folder, path, content)
            if not left[0]:
                raise KeyboardInterrupt
            left[0] -= 1
            return real(folder, path, content)

        monkeypatch.setattr(ConfinedFolder, "write", write)
        with pytest.raises(KeyboardInterrupt):
            generate(model, workspace, OPTIONS)
        monkeypatch.undo()
        generate(model, workspace, OPTIONS)
        assert is_fine(workspace, model)
        assert (workspace / WAITER).read_text().count('on("TPay")') == 1
        generate(kitchen(), workspace, OPTIONS)
        (workspace / WAITER).write_text(HANDWRITTEN)
    manifest = read_manifest(workspace)
    assert manifest is not None
    assert manifest.pending == {}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is not a manifest: "),
        ("[]", "is not a manifest: "),
        ('{"schema": 1}', "is not a manifest: "),
        (
            '{"schema": 99}',
            "has the schema 99; the newest supported one is 1 (use a later version of DiNeROS)",
        ),
        ("\0", "is not a manifest: "),
    ],
)
def test_a_broken_manifest_is_refused(workspace: Path, text: str, said: str) -> None:
    (workspace / PLACE).write_text(text)
    with pytest.raises(ManifestError, match=r"manifest\.json: ") as error:
        generate(kitchen(), workspace, OPTIONS)
    assert said in str(error.value)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "ws").write_text("a file")
    with pytest.raises((WorkspaceError, ManifestError), match="ws"):
        generate(kitchen(), tmp_path / "ws", OPTIONS)
    assert (tmp_path / "ws").read_text() == "a file"
