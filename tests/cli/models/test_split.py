"""``dineros split``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import elements, pn, rtm
from dineros.metamodel.build import flow
from dineros.metamodel.files import load, save
from tests.cli.conftest import Run


def test_one_file_for_each_node_net(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "nodes"
    result = run("split", model, "-o", out)
    assert result.exit_code == 0
    assert result.stdout == (
        f"talker -> {out}/talker.rtm.xmi: 2 places, 1 transition, 1 port, 1 signal\n"
        f"listener -> {out}/listener.rtm.xmi: 2 places, 1 transition, 1 port, 0 signals\n"
        f"{model}: 2 node nets\n"
    )
    assert sorted(path.name for path in out.iterdir()) == ["listener.rtm.xmi", "talker.rtm.xmi"]
    said = elements.find(load(out / "talker.rtm.xmi"), "Said", rtm.Place)
    (port,) = said.ports
    assert isinstance(port, rtm.PublisherPort)
    assert (port.channel, port.topic, port.limit) == ("Chatter", "chatter", 10)


def test_settings_and_json(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "nodes"
    result = run("split", model, "-o", out, "--json", "--set", "Words.tokens=7")
    rows = json.loads(result.stdout)["nodes"]
    assert [row["node"] for row in rows] == ["talker", "listener"]
    assert rows[0]["file"] == str(out / "talker.rtm.xmi")
    assert elements.find(load(rows[0]["file"]), "Words", pn.Place).tokens == 7


def test_again_gives_the_same_bytes_and_leaves_other_files_alone(
    run: Run, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "nodes"
    assert run("split", model, "-o", out).exit_code == 0
    (out / "other.txt").write_text("mine")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert run("split", model, "-o", out).exit_code == 0
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_an_invalid_model_is_refused(run: Run, broken: Path, tmp_path: Path) -> None:
    result = run("split", broken, "-o", tmp_path / "nodes")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert "is not valid: " in result.stderr
    assert f"`dineros validate {broken}`" in result.stderr
    assert not (tmp_path / "nodes").exists()


def test_a_plain_net_is_refused(run: Run, tmp_path: Path) -> None:
    net = pn.Net(id="plain", pages=[pn.Page(id="page", objects=[pn.Place(id="p"), pn.Transition(id="t")])])
    flow(*net.pages[0].objects)
    save(net, tmp_path / "plain.pnml")
    result = run("split", tmp_path / "plain.pnml", "-o", tmp_path / "nodes")
    assert result.exit_code == 2
    assert "plain.pnml: holds a plain net, but this command needs a system model" in result.stderr


def test_a_file_in_the_folders_place_is_refused(run: Run, model: Path) -> None:
    result = run("split", model, "-o", model)
    assert (result.exit_code, result.stderr) == (2, f"{model}: is a file (name a folder)\n")


def test_if_one_node_cannot_be_written_none_is(run: Run, model: Path, tmp_path: Path) -> None:
    net = load(model)
    elements.find(net, "Noted").id = "//@pages.0"  # an id in PNML, but not in XMI
    path = tmp_path / "odd.pnml"
    save(net, path)
    result = run("split", path, "-o", tmp_path / "nodes")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert "looks like the path of an element" in result.stderr
    assert not (tmp_path / "nodes").exists()


def test_a_new_folder_is_whole_or_not_there(
    run: Run, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = [2]  # synchronised: the first file and its folder

    def fsync(_: int) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr("dineros.metamodel.files.atomic.os.fsync", fsync)
    result = run("split", model, "-o", tmp_path / "new")
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{tmp_path}/new/listener.rtm.xmi: cannot be written: No space")
    assert [path.name for path in tmp_path.iterdir()] == [model.name]
