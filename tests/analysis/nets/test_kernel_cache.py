"""Compiled kernels that are kept: never used once any of their sources has changed, and never in the way."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dineros.analysis.nets import kernel_cache
from dineros.analysis.nets.kernel_cache import digest, made, sources

NAME = "dineros-kernels-0123"


def room(folder: Path) -> Path:
    """Make a room with two kernels, one of which has a constant from a module that is none."""
    (folder / "engine/kernels").mkdir(parents=True)
    (folder / "engine/kernels/one.py").write_text("from dineros.analysis.engine.words import BITS\n")
    (folder / "engine/kernels/two.py").write_text("import numpy\n")
    (folder / "engine/words.py").write_text("BITS = 62\n")
    (folder / "engine/other.py").write_text("nothing of a kernel\n")
    return folder


@pytest.mark.parametrize("changed", ["engine/kernels/one.py", "engine/kernels/two.py", "engine/words.py"])
def test_any_source_counts(tmp_path: Path, changed: str) -> None:
    here = room(tmp_path)
    before = digest(sources(here))
    with (here / changed).open("a") as file:
        file.write("# changed\n")
    assert digest(sources(here)) != before


def test_nothing_else_counts(tmp_path: Path) -> None:
    here = room(tmp_path)
    before = digest(sources(here))
    (here / "engine/other.py").write_text("changed\n")
    assert digest(sources(here)) == before


def test_a_kernel_that_comes_or_goes_counts(tmp_path: Path) -> None:
    here = room(tmp_path)
    before = digest(sources(here))
    (here / "engine/kernels/three.py").write_text("")
    assert digest(sources(here)) != before


def test_all_kernels_of_the_engines_are_among_them() -> None:
    decorated = {
        file for file in kernel_cache.ROOM.rglob("*.py") if "@kernel(" in file.read_text(encoding="utf-8")
    }
    assert len(decorated) > 8
    assert decorated <= set(sources(kernel_cache.ROOM))
    bare = {file for file in kernel_cache.ROOM.rglob("*.py") if "njit(" in file.read_text(encoding="utf-8")}
    assert bare == {Path(kernel_cache.__file__)}


def test_those_of_other_versions_go(tmp_path: Path) -> None:
    (tmp_path / "dineros-kernels-4567/kept").mkdir(parents=True)
    (tmp_path / "others").mkdir()
    assert made(tmp_path, NAME) == tmp_path / NAME
    assert sorted(file.name for file in tmp_path.iterdir()) == [NAME, "others"]


def test_a_link_of_that_name_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "elsewhere/mine").mkdir(parents=True)
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache/dineros-kernels-4567").symlink_to(tmp_path / "elsewhere")
    assert made(tmp_path / "cache", NAME) is not None
    assert (tmp_path / "elsewhere/mine").is_dir()


def test_where_nothing_can_be_written_none_are_kept(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert made(tmp_path / "file", NAME) is None


PROGRAM = """
import sys
from dineros.analysis.nets import kernel_cache
if sys.argv[1] == "nowhere":
    kernel_cache.made = lambda home, name: None
from dineros.analysis.explicit.kernels.stubborn import lowest_bit
import numpy as np
print(lowest_bit(np.uint64(8)))
"""


@pytest.mark.long
@pytest.mark.parametrize("where", ["nowhere", "here"])
def test_they_run_wherever_they_are_kept(tmp_path: Path, where: str) -> None:
    command = [sys.executable, "-c", PROGRAM, where]
    environment = {"PATH": "", "HOME": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert run.stdout.strip().isdigit()
    kept = list(tmp_path.glob("kept/dineros-kernels-*/*/*.nbi"))
    assert bool(kept) == (where == "here")


def test_kernels_that_call_one_share_a_compilation_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_cache, "_folder", lambda given: None)

    @kernel_cache.kernel()
    def scaled(number, factor, is_negated):  # type: ignore[no-untyped-def]
        return -number * factor if is_negated else number * factor

    @kernel_cache.kernel()
    def total(numbers):  # type: ignore[no-untyped-def]
        result = scaled(numbers.size, 2, True)
        for number in numbers:
            result += scaled(number, 3, number > 2) + scaled(number, numbers.size, False)
        return result

    assert total(np.array([1, 2, 2**31 - 1], dtype=np.int32)) == total.py_func(np.array([1, 2, 2**31 - 1]))
    assert len(scaled.signatures) == 1


CALLED_FOR_BOTH = """
import sys, time
from numba.core.caching import IndexDataCacheFile

load, argument = IndexDataCacheFile._load_index, eval(sys.argv[1])

def load_slowly(self):
    index = load(self)
    time.sleep(1)  # so that another process looks into the index before this one writes it
    return index

IndexDataCacheFile._load_index = load_slowly if sys.argv[2] == "slowly" else load

from doubling import doubled
print(doubled(argument), sum(doubled.stats.cache_hits.values()))
"""

DOUBLING = """
from dineros.analysis.nets.kernel_cache import kernel

@kernel()
def doubled(number):
    return number + number
"""


@pytest.mark.long
def test_two_processes_that_compile_one_kernel_do_not_mix_up_their_files(tmp_path: Path) -> None:
    (tmp_path / "doubling.py").write_text(DOUBLING)
    environment = {
        "PATH": "",
        "HOME": str(tmp_path),
        "NUMBA_CACHE_DIR": str(tmp_path / "kept"),
        "PYTHONPATH": str(tmp_path),
    }

    def start(argument: str, pace: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", CALLED_FOR_BOTH, argument, pace]
        return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)

    both = [start("21", "slowly"), start("0.25", "slowly")]
    assert [process.communicate()[0].split() for process in both] == [["42", "0"], ["0.5", "0"]]
    later = [start("21", "at once"), start("0.25", "at once")]
    assert [process.communicate()[0].split() for process in later] == [["42", "1"], ["0.5", "1"]]
