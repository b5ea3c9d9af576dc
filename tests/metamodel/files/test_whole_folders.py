"""New folders: complete, or not there."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.whole_folders import whole_folder


@pytest.mark.parametrize("name", ["new", "a/b/new"])
@pytest.mark.parametrize("kind", [OSError, ModelFileError, KeyboardInterrupt, MemoryError])
def test_a_fault_leaves_nothing(tmp_path: Path, name: str, kind: type[BaseException]) -> None:
    path = tmp_path / name
    with pytest.raises(ModelFileError if kind is OSError else kind), whole_folder(path) as folder:
        (folder / "file").write_text("a")
        raise kind("No space left on device")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_there_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "a" / "new"
    with whole_folder(path) as folder:
        (folder / "file").write_text("a")
        assert not path.exists()
    assert [file.name for file in path.iterdir()] == ["file"]
    assert [file.name for file in path.parent.iterdir()] == ["new"]
    mask = os.umask(0)
    os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o777 & ~mask


def test_a_folder_that_existed_keeps_what_it_had(tmp_path: Path) -> None:
    (tmp_path / "old").write_text("a")
    with pytest.raises(ModelFileError), whole_folder(tmp_path) as folder:
        assert folder == tmp_path
        raise ModelFileError("No space left on device")
    assert [file.name for file in tmp_path.iterdir()] == ["old"]


def test_a_folder_that_was_made_meanwhile_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "new"
    with pytest.raises(ModelFileError, match=r"new: cannot be made"), whole_folder(path) as folder:
        (folder / "file").write_text("a")
        path.mkdir()
        (path / "other").write_text("b")
    assert [file.name for file in tmp_path.iterdir()] == ["new"]
    assert [file.name for file in path.iterdir()] == ["other"]


def test_errors_name_the_folder(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError) as caught, whole_folder(tmp_path / "new") as folder:
        raise ModelFileError("cannot be written", location=Location(folder / "a"))
    assert str(caught.value) == f"{tmp_path / 'new' / 'a'}: cannot be written"


def test_what_a_killed_writer_left_is_removed_but_not_what_is_being_written(tmp_path: Path) -> None:
    program = (
        "import os, sys\n"
        "from pathlib import Path\n"
        "from dineros.metamodel.files.whole_folders import whole_folder\n"
        "with whole_folder(Path(sys.argv[1])) as folder:\n"
        "    (folder / 'file').write_text('a')\n"
        f"    os.kill(os.getpid(), {int(signal.SIGKILL)})\n"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "new")], check=False)
    assert [file.name for file in tmp_path.iterdir()] == [".new.0.dineros-tmp"]
    with whole_folder(tmp_path / "new") as folder:
        assert list(folder.iterdir()) == []
        with pytest.raises(ModelFileError), whole_folder(tmp_path / "new") as other:
            assert other != folder
            raise ModelFileError("no")
        assert folder.is_dir()
    assert [file.name for file in tmp_path.iterdir()] == ["new"]


def test_a_file_system_without_locks_gets_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Temporary folders that others left there are not removed, as they may be in use."""
    left = tmp_path / ".new.0.dineros-tmp"
    left.mkdir()

    def flock(descriptor: int, operation: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", flock)
    with whole_folder(tmp_path / "new") as folder:
        (folder / "file").write_text("a")
    assert sorted(file.name for file in tmp_path.iterdir()) == [left.name, "new"]
