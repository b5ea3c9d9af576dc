import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel import pn, trace
from dineros.metamodel.elements import find
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import SUFFIXES, load, load_any, save
from tests.support.equality import differences
from tests.support.systems.small import small_net, small_system


@pytest.mark.parametrize("suffix", [".xmi", ".sym", ".sym.xmi", ".XMI", ".pnml"])
def test_the_suffix_chooses_the_format(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"model{suffix}"
    save(small_system(), path)
    assert (b"<pnml" in path.read_bytes()) == suffix.endswith("pnml")
    assert load(str(path)).id == "talk"


def test_a_plain_net_goes_through_all_formats(tmp_path: Path) -> None:
    net = small_net()
    find(net, "start", pn.Transition).interval = None
    for name in ("a.xmi", "b.pnml", "c.xmi"):
        save(net, tmp_path / name)
        net = load(tmp_path / name)
    assert differences(net, load(tmp_path / "a.xmi")) == []
    save(net, tmp_path / "d.net")
    save(load(tmp_path / "d.net"), tmp_path / "e.xmi")
    save(load(tmp_path / "e.xmi"), tmp_path / "f.net")
    assert (tmp_path / "d.net").read_bytes().splitlines()[1:] == (
        tmp_path / "f.net"
    ).read_bytes().splitlines()[1:]


@pytest.mark.parametrize("name", ["model", "model.txt", "model.pnm1", ".xmi"])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path: Path, name: str) -> None:
    for work in (load, lambda path: save(small_net(), path)):
        with pytest.raises(ModelFileError, match=r"suffix.*(did you mean|known are)"):
            work(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_net_is_loaded_as_such_only(tmp_path: Path) -> None:
    path = tmp_path / "trace.xmi"
    save(trace.TraceModel(source="a"), path)
    assert isinstance(load_any(path), trace.TraceModel)
    with pytest.raises(ModelFileError, match="holds a TraceModel, not a net"):
        load(path)
    for suffix in (".pnml", ".net"):
        with pytest.raises(ModelFileError, match=r"cannot hold a TraceModel \(use \.xmi\)"):
            save(trace.TraceModel(), tmp_path / f"trace{suffix}")


def test_no_format_is_imported_before_it_is_needed() -> None:
    program = (
        "import sys, dineros.metamodel.files\n"
        "print([name for name in sys.modules if name in ('lxml', 'lark', 'pyecore')])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
    assert ".net" in SUFFIXES


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("net.tapn", "TAPAAL's own format: export the net as PNML"),
        ("net.bpmn", "exports one as PNML"),
        ("net.llnet", "a net of PEP"),
        ("net.ndr", "TINA's drawing: save it as .net"),
        ("net.PNPRO", "GreatSPN"),
        ("net.pnt", "a net of INA"),
        ("net.rnw", "a drawing of Renew"),
        ("net.spped", "a net of Snoopy"),
        ("run.mcap", "this is a recording: 'dineros import --bag'"),
        ("net.pmnl", "did you mean '.pnml'"),
    ],
)
def test_files_of_other_tools_are_named_for_what_they_are(name: str, hint: str, tmp_path: Path) -> None:
    with pytest.raises(ModelFileError) as caught:
        load(tmp_path / name)
    assert hint in str(caught.value)
    if "did you" not in hint:
        assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize("name", ["net.pn", "net.ptn", "net.nets", "net.ctl", "net.xmm"])
def test_nothing_advises_to_rename_a_file_that_is_there(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("PN", encoding="utf-8")
    with pytest.raises(ModelFileError) as caught:
        load(path)
    assert "known are .xmi" in str(caught.value) and "did you mean" not in str(caught.value)


@pytest.mark.parametrize("name", ["a.pnml", "a.net", "a.xmi"])
def test_a_pointer_of_git_lfs_is_named(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", encoding="utf-8")
    with pytest.raises(ModelFileError, match=r"pointer of Git LFS.*git lfs pull"):
        load(path)
