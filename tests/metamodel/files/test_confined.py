"""A folder from somebody else: whatever it holds, nothing outside is read, written or removed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.confined import ConfinedFolder


def _start(folder: ConfinedFolder, path: str) -> None:
    os.close(folder.start(path))


WORK: dict[str, Callable[[ConfinedFolder, str], object]] = {
    "read": lambda folder, path: folder.read(path),
    "write": lambda folder, path: folder.write(path, b"theirs"),
    "start": _start,
    "remove": lambda folder, path: folder.remove(path),
    "remove_tree": lambda folder, path: folder.remove_tree(path),
}
"""What is done with a file or folder."""


@pytest.fixture
def folder(tmp_path: Path) -> ConfinedFolder:
    """Return a folder beside a file and a folder that are none of its business."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "precious").write_text("mine")
    (tmp_path / "inside").mkdir()
    return ConfinedFolder(tmp_path / "inside")


@pytest.fixture(autouse=True)
def _untouched(folder: ConfinedFolder) -> Iterator[None]:
    yield
    outside = folder.root.parent / "outside"
    assert [path.name for path in outside.iterdir()] == ["precious"]
    assert (outside / "precious").read_text() == "mine"


@pytest.mark.parametrize("work", WORK)
@pytest.mark.parametrize(
    "path", ["../outside/precious", "/etc/passwd", "a/../../outside/precious", "", ".", "..", "a//b", "n\0"]
)
def test_no_path_leads_out(folder: ConfinedFolder, work: str, path: str) -> None:
    with pytest.raises(ModelFileError, match=r"inside: holds no file .*: the path leads out"):
        WORK[work](folder, path)


@pytest.mark.parametrize("work", WORK)
def test_no_link_on_the_way_is_followed(folder: ConfinedFolder, work: str) -> None:
    (folder.root / "link").symlink_to("../outside")
    with pytest.raises(ModelFileError, match="inside/link: is a symbolic link, which is not followed here"):
        WORK[work](folder, "link/precious")
    with pytest.raises(ModelFileError, match="inside/link: is a symbolic link, which is not followed here"):
        folder.files("link")


@pytest.mark.parametrize("work", sorted(WORK.keys() - {"remove"}))
@pytest.mark.parametrize("target", ["../outside/precious", "../outside/new"])
def test_no_link_at_the_end_is_followed(folder: ConfinedFolder, work: str, target: str) -> None:
    (folder.root / "link").symlink_to(target)
    with pytest.raises(ModelFileError, match="inside/link: is a symbolic link, which is not followed here"):
        WORK[work](folder, "link")


def test_a_link_is_removed_and_its_target_stays(folder: ConfinedFolder) -> None:
    (folder.root / "a").mkdir()
    (folder.root / "a" / "link").symlink_to("../../outside/precious")
    folder.remove("a/link")
    (folder.root / "b").mkdir()
    (folder.root / "b" / "link").symlink_to("../../outside")
    folder.remove_tree("b")
    assert list(folder.root.iterdir()) == []


def test_what_python_compiled_goes_with_its_folder(folder: ConfinedFolder) -> None:
    folder.write("src/a/b.py", b"")
    folder.write("src/a/__pycache__/b.pyc", b"")
    folder.write("src/kept", b"")
    folder.remove("src/a/b.py")
    assert folder.files("") == ["src/kept"]
    assert not (folder.root / "src" / "a").exists()
    folder.write("src/c/d.py", b"")
    (folder.root / "src/c/__pycache__").symlink_to("../../../outside")
    folder.remove("src/c/d.py")
    assert (folder.root / "src/c/__pycache__").is_symlink()


@pytest.mark.parametrize("work", ["read", "write", "start"])
def test_a_pipe_does_not_hang(folder: ConfinedFolder, work: str) -> None:
    os.mkfifo(folder.root / "pipe")
    with pytest.raises(ModelFileError, match="not a plain file"):
        WORK[work](folder, "pipe")


def test_what_is_not_there_is_none(folder: ConfinedFolder) -> None:
    for path in ("c", "a/b/c"):  # the file alone, or its folder as well
        assert folder.read(path) is None
        assert folder.files(path) == []
        folder.remove(path)
        folder.remove_tree(path)
        folder.take_away_leftovers(path)
    assert list(folder.root.iterdir()) == []
