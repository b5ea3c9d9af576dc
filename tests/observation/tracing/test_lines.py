"""The program that reads CTF: missing, failing, silent, talkative; and the real one where it is."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from dineros.observation.tracing import Tracing, TracingError
from dineros.observation.tracing.lines import PROGRAM
from tests.observation.tracing.test_reading import DATA, TEXT, read
from tests.support.traces import program


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "trace").mkdir()
    return tmp_path / "trace"


def stand_in(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, script: str) -> None:
    place = program(tmp_path / "bin", script)
    monkeypatch.setenv("PATH", f"{place}{os.pathsep}{os.environ['PATH']}")


def test_a_folder_is_read_by_the_program(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(
        monkeypatch,
        tmp_path,
        f'echo "$@" > {tmp_path}/options\n'
        f"echo 'WARNING: Tracer discarded 12 events between [1] and [2] in trace' >&2\ncat {TEXT}",
    )
    tracing = Tracing(folder)
    assert list(tracing.events()) == read(TEXT)
    assert (tracing.discarded, tracing.odd) == (12, 0)
    assert (tmp_path / "options").read_text().split() == [
        "--clock-seconds",
        "--no-delta",
        "--color=never",
        str(folder.resolve()),
    ]


def test_it_is_missing(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(TracingError, match=r"babeltrace2, which is not on the PATH \(install it") as raised:
        read(folder)
    assert "\n" not in str(raised.value)


def test_it_does_not_run(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (program(tmp_path / "bin", "") / "babeltrace2").write_bytes(b"\x7fELF")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    with pytest.raises(TracingError, match="does not run"):
        read(folder)


def test_it_fails_after_some_events(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = (
        "11-23 18:33 E CLI something\\n\\nERROR:    [Babeltrace CLI] (a.c:2480)\\n  Cannot create.\\n"
        f"CAUSED BY [auto-disc] (fs.c:803)\\n  Failed to index CTF stream file '{folder}/c_0'\\n"
    )
    stand_in(monkeypatch, tmp_path, f'head -5 {TEXT}\nprintf "{said}" >&2\nexit 1')
    with pytest.raises(
        TracingError, match=r"cannot read it: Failed to index CTF stream file 'c_0' \("
    ) as raised:
        read(folder)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("before", ["", f"head -3 {TEXT}", f"head -3 {TEXT}; exec >&-"])
def test_it_says_no_more(before: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So the real one does where the file ``metadata`` is cut off."""
    stand_in(monkeypatch, tmp_path, f"echo $$ > {tmp_path}/id\n{before}\nexec sleep 1000")
    with pytest.raises(TracingError, match=r"has printed nothing for 0\.5 s"):
        list(Tracing(folder, stalled=0.5).events())
    assert not Path(f"/proc/{(tmp_path / 'id').read_text().strip()}").exists()


def test_warnings_without_end_are_no_progress(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, tmp_path, "while :; do echo damaged >&2; sleep 0.05; done")
    with pytest.raises(TracingError, match="has printed nothing"):
        list(Tracing(folder, stalled=0.5).events())


def test_it_ends_when_nobody_wants_more(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, tmp_path, f"echo $$ > {tmp_path}/id\ncat {TEXT}\nexec sleep 1000")
    events = Tracing(folder).events()
    assert next(events).name == "rcl_node_init"
    events.close()  # type: ignore[attr-defined]
    assert not Path(f"/proc/{(tmp_path / 'id').read_text().strip()}").exists()


def test_the_trace_and_its_text_tell_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the real program, where it is; nothing of ours needs it."""
    is_real = shutil.which(PROGRAM) is not None
    if not is_real:
        stand_in(monkeypatch, tmp_path, f"cat {TEXT}")
    found, expected = read(DATA / "lttng"), read(TEXT)
    assert [each[1:] for each in found] == [each[1:] for each in expected]
    assert len({a.time - b.time for a, b in zip(found, expected, strict=True)}) == 1
    if is_real:
        cut = tmp_path / "cut"
        shutil.copytree(DATA / "lttng", cut)
        stream = cut / "ust/uid/0/64-bit/c_0"
        stream.write_bytes(stream.read_bytes()[:5000])
        with pytest.raises(TracingError, match="cannot read it: Failed to index"):
            read(cut)
        (tmp_path / "nothing").mkdir()
        with pytest.raises(TracingError, match="cannot read it: No source component"):
            read(tmp_path / "nothing")
