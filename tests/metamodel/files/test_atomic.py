import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import save
from dineros.metamodel.files.atomic import take_away_leftovers, write_atomically
from tests.support.systems.small import small_net


def test_a_file_is_written_and_nothing_else_is_left(tmp_path: Path) -> None:
    write_atomically(tmp_path / "a", b"first")
    write_atomically(tmp_path / "a", b"second")
    assert (tmp_path / "a").read_bytes() == b"second"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_an_existing_file_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"old")
    path.chmod(0o640)
    write_atomically(path, b"new")
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_new_file_gets_the_mode_of_the_umask(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    write_atomically(tmp_path / "a", b"new")
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_symbolic_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"old")
    (tmp_path / "link").symlink_to("target")
    write_atomically(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"new"


@pytest.mark.parametrize("fault", ["fchmod", "fsync", "replace"])
@pytest.mark.parametrize("kind", [OSError, KeyboardInterrupt, MemoryError])
def test_a_fault_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str, kind: type[BaseException]
) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"old")

    def fail(*_: object, **__: object) -> None:
        raise kind(28, "No space left on device")

    monkeypatch.setattr(f"dineros.metamodel.files.atomic.os.{fault}", fail)
    with pytest.raises(ModelFileError if kind is OSError else kind, match="No space left"):
        write_atomically(path, b"new")
    monkeypatch.undo()
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("moment", ["fsync", "replace"])
def test_a_killed_process_leaves_the_old_file(tmp_path: Path, moment: str) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"old")
    program = (
        "import os, signal, sys\n"
        "from dineros.metamodel.files import atomic\n"
        f"atomic.os.{moment} = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)\n"
        "atomic.write_atomically(sys.argv[1], b'new' * 1000)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"old"


def test_a_model_that_cannot_be_stored_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "net.xmi"
    path.write_bytes(b"old")
    net = small_net()
    net.name = "bell \a"
    with pytest.raises(ModelFileError, match="XML cannot carry"):
        save(net, path)
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["net.xmi"]


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, message in [
        (tmp_path, "it is a directory"),
        (tmp_path / "missing" / "a", "create the folder first"),
        (tmp_path / "pipe", "it is not a plain file"),
        (tmp_path / "nul\0", "null byte"),
    ]:
        with pytest.raises(ModelFileError, match=message):
            write_atomically(path, b"new")


def test_what_a_killed_writer_left_goes_with_the_next_write(tmp_path: Path) -> None:
    path = tmp_path / "a"
    test_a_killed_process_leaves_the_old_file(tmp_path, "fsync")
    assert len(list(tmp_path.iterdir())) == 2
    (tmp_path / ".a.0.tmp").write_bytes(b"somebody else's")
    write_atomically(path, b"new")
    assert sorted(file.name for file in tmp_path.iterdir()) == [".a.0.tmp", "a"]


def test_what_a_living_writer_writes_is_left_to_it(tmp_path: Path) -> None:
    program = (
        "import os, sys\n"
        "from dineros.metamodel.files import atomic\n"
        "real = atomic.os.fsync\n"
        "def wait(descriptor):\n"
        "    print('writing', flush=True)\n"
        "    sys.stdin.readline()\n"
        "    real(descriptor)\n"
        "atomic.os.fsync = wait\n"
        "atomic.write_atomically(sys.argv[1], b'theirs')\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "a")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "writing\n"
        write_atomically(tmp_path / "a", b"ours")
        folder = os.open(tmp_path, os.O_RDONLY)
        take_away_leftovers(folder)
        os.close(folder)
        assert (tmp_path / "a").read_bytes() == b"ours"
        other.communicate("continue\n\n", timeout=60)
    assert other.returncode == 0
    assert (tmp_path / "a").read_bytes() == b"theirs"
    assert [file.name for file in tmp_path.iterdir()] == ["a"]


def test_a_link_is_refused_where_none_is_followed(tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"old")
    (tmp_path / "link").symlink_to("target")
    with pytest.raises(ModelFileError, match="link: is a symbolic link, which is not followed here"):
        write_atomically(tmp_path / "link", b"new", follow_links=False)
    assert (tmp_path / "target").read_bytes() == b"old"


def test_a_link_in_place_of_the_temporary_file_is_not_written(tmp_path: Path) -> None:
    (tmp_path / "victim").write_bytes(b"precious")
    (tmp_path / ".a.0.dineros-tmp").symlink_to("victim")
    write_atomically(tmp_path / "a", b"new")
    assert (tmp_path / "victim").read_bytes() == b"precious"
    assert (tmp_path / "a").read_bytes() == b"new"
