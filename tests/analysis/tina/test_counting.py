"""The way to TINA and back, with a stand-in: TINA itself is not to be had here and was never tried.

The stand-in is a program of ours that takes the command line of ``tina``, reads the net that was written,
counts it by the reference search and prints a digest in TINA's published form.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.tina import TinaCounts, TinaError, count, read_digest
from tests.analysis import classic_nets as classic

ROOT = Path(__file__).resolve().parents[3]
STAND_IN = """#!{python}
# A stand-in for tina, not tina.
import sys
sys.path.insert(0, {root!r})
from dineros.analysis.nets.models import compile_net
from dineros.metamodel.files import load
from tests.analysis.reference_search import reference_search
assert sys.argv[1:3] == ["-R", "-q"], sys.argv
net = compile_net(load(sys.argv[3]))
found = reference_search(net, 5000)
print(f"# net {{sys.argv[3]}}, {{len(net.places)}} places, {{len(net.transitions)}} transitions, 0 arcs")
print("# bounded, not live, not reversible")
print("# abstraction        count      props      psets       dead       live")
print(f"#      states {{found.markings:12}} {{len(net.places):10}}    ? {{found.deadlocks:10}}      0")
print(f"# transitions {{found.arcs:12}} {{len(net.transitions):10}}    ?          0      0")
"""
NETS = {
    "kanban": classic.kanban(1),
    "philosophers": classic.philosophers(4),
    "arcs of all kinds": CompiledNet.build(
        {"a": 3, "odd name": 0, "c[1]": 1},
        [
            Transition("t", {"a": 2}, {"odd name": 3}, {"c[1]": 2}),
            Transition("u v", {"odd name": 1}, {"c[1]": 1}, {"c[1]": 4}, {"a": 1}),
        ],
    ),
}


def stand_in(folder: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    program = folder / "tina"
    program.write_text(text, encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.long
@pytest.mark.parametrize("name", NETS)
def test_counts_come_back(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, STAND_IN.format(python=sys.executable, root=str(ROOT)))
    net = NETS[name]
    counts = count(net)
    assert counts.is_bounded
    own = state_space(net, budget=Budget(1 << 24))
    assert (counts.states, counts.arcs, counts.deadlocks) == (own.states, own.arcs, own.deadlocks)


def test_a_recorded_digest() -> None:
    """As a public page shows it for a net of sixteen places."""
    digest = """# net Banker, 16 places, 6 transitions, 54 arcs
# bounded, not live, possibly reversible
# abstraction        count      props      psets       dead       live
#      states            7         16          ?          2          2
# transitions            6          6          ?          0          0
"""
    assert read_digest(digest) == TinaCounts(7, 6, 2, True)
    for unsure in ("unbounded", "not bounded", "possibly bounded"):
        assert not read_digest(digest.replace("bounded", unsure)).is_bounded


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("#!/bin/sh\necho 'net.net, line 3: syntax error' >&2\nexit 2\n", "exit status 2: net.net, line 3"),
        ("#!/bin/sh\necho hello\n", "has no digest"),
        (
            "#!/bin/sh\necho '# net n, 1 places, 2 transitions, 0 arcs'\n",
            "has read 1 places and 2 transitions",
        ),
        ("#!/bin/sh\nexec sleep 20\n", "more than 0.2 s"),
    ],
)
def test_what_goes_wrong_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str, says: str
) -> None:
    stand_in(tmp_path, monkeypatch, program)
    with pytest.raises(TinaError, match=says):
        count(NETS["kanban"], Budget(seconds=0.2 if "sleep" in program else None))


def test_time_that_ran_out_is_no_error_of_a_state_space(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(tmp_path, monkeypatch, "#!/bin/sh\nexec sleep 20\n")
    found = state_space(NETS["kanban"], "tina", Budget(seconds=0.2))
    assert (found.complete, found.states, found.reason) == (False, None, "time ran out")


def test_without_tina_the_hint_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(TinaError, match="not on the PATH"):
        count(NETS["kanban"])
