"""The way of a time Petri net to TINA and back, with a stand-in: TINA itself was never tried.

The stand-in reads the net that was written, so a count that comes back shows that intervals, read arcs and
priorities went out as they are.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.nets import Interval, TimedNet, compile_timed_net
from dineros.analysis.tina import TinaError, count_classes
from dineros.analysis.tina.timed_models import to_timed_model
from tests.analysis.timed.time_nets import lively_net

ROOT = Path(__file__).resolve().parents[3]
STAND_IN = """#!{python}
# A stand-in for tina, not tina.
import sys
sys.path.insert(0, {root!r})
from dineros.analysis.timed.nets import compile_timed_net
from dineros.analysis.timed.graph import class_graph
from dineros.metamodel.files import load
assert sys.argv[2] == "-q" and sys.argv[1] in ("-W", "-M", "-S", "-E", "-A"), sys.argv
net = compile_timed_net(load(sys.argv[3]))
found = class_graph(net, sys.argv[1][1])
places, transitions = len(net.untimed.places), len(net.untimed.transitions)
print(f"# net net, {{places}} places, {{transitions}} transitions, 0 arcs")
print("# bounded, not live, not reversible")
print("# abstraction        count      props      psets       dead       live")
print(f"#     classes {{found.classes:12}} {{places:10}}    ? {{found.deadlocks:10}}      0")
print(f"# transitions {{found.edges:12}} {{transitions:10}}    ?          0      0")
"""


def stand_in(folder: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    program = folder / "tina"
    program.write_text(text, encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


def in_units(net: TimedNet) -> TimedNet:
    """Return the same net with whole bounds."""

    def scaled(one: Interval) -> Interval:
        latest = None if one.latest is None else one.latest / net.unit
        return replace(one, earliest=one.earliest / net.unit, latest=latest)

    return replace(net, intervals=tuple(map(scaled, net.intervals)))


@pytest.mark.parametrize("seed", range(30))
def test_what_goes_out_is_the_net_with_whole_times(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 2 == 1).net
    again = compile_timed_net(to_timed_model(net, "net"))
    expected = in_units(net)
    assert again.intervals == expected.intervals
    assert again.above == expected.above
    assert again.untimed.transitions == net.untimed.transitions
    for ours, theirs in ((again.take, net.take), (again.put, net.put), (again.untimed.pre, net.untimed.pre)):
        rows = range(len(net.intervals))
        assert [dict(ours.row(t)) for t in rows] == [dict(theirs.row(t)) for t in rows]
    assert all(
        bound.denominator == 1
        for one in again.intervals
        for bound in (one.earliest, one.latest or Fraction(0))
    )


@pytest.mark.long
@pytest.mark.parametrize("kind", ["W", "M", "S", "E"])
def test_counts_come_back(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, STAND_IN.format(python=sys.executable, root=str(ROOT)))
    net = lively_net(Random(5)).net
    ours, theirs = class_graph(net, kind), count_classes(net, kind)  # type: ignore[arg-type]
    assert (theirs.classes, theirs.edges, theirs.deadlocks) == (ours.classes, ours.edges, ours.deadlocks)
    assert (theirs.complete, theirs.engine, theirs.construction, theirs.markings) == (
        True,
        "tina",
        kind,
        None,
    )
    assert theirs.unit == str(net.unit)


DIGEST = """# net ifip, {places} places, {transitions} transitions, 17 arcs                #
# {bounded}, live, reversible                                              #
# abstraction        count      props      psets       dead       live    #
#     classes           12          5         12          0         12    #
# transitions           29          5          5          0          5    #
"""


@pytest.mark.parametrize(
    ("bounded", "classes", "reason"),
    [("bounded", 12, ""), ("possibly bounded", None, "tina does not find the net bounded")],
)
def test_a_digest_is_read(
    bounded: str, classes: int | None, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    net = lively_net(Random(5)).net
    sizes = {"places": len(net.untimed.places), "transitions": len(net.untimed.transitions)}
    digest = DIGEST.format(bounded=bounded, **sizes)
    stand_in(tmp_path, monkeypatch, f"#!/bin/sh\ncat <<'END'\n{digest}END\n")
    found = count_classes(net, "W")
    assert (found.classes, found.complete, found.reason) == (classes, not reason, reason)


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("#!/bin/sh\necho hello\n", "has no digest"),
        ("#!/bin/sh\necho '# net n, 1 places, 2 transitions, 0 arcs'\n", "has read 1 places and 2"),
        ("#!/bin/sh\necho 'net.net, line 3: syntax error' >&2\nexit 2\n", "exit status 2: net.net, line 3"),
    ],
)
def test_what_goes_wrong_is_told(
    program: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(tmp_path, monkeypatch, program)
    with pytest.raises(TinaError, match=says):
        count_classes(lively_net(Random(5)).net, "W")


def test_time_that_ran_out_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, "#!/bin/sh\nexec sleep 20\n")
    found = count_classes(lively_net(Random(5)).net, "W", Budget(seconds=0.2))
    assert (found.complete, found.classes, found.reason) == (False, None, "time ran out")
