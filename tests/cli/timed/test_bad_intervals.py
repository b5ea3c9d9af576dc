"""Intervals that are none, in each format: one line and exit status 2, or what `check --time` finds."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Run

HUGE = "1" + "0" * 30
NET = "net n\ntr t INTERVAL p -> q\ntr back [0,0] q -> p\npl p (1)\n"
PNML = """<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n" \
type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">
<place id="p"><initialMarking><text>1</text></initialMarking></place><place id="q"/>
<transition id="t"><delay>INTERVAL</delay></transition>
<transition id="back"><delay>NOW</delay></transition>
<arc id="a" source="p" target="t"/><arc id="b" source="t" target="q"/>
<arc id="c" source="q" target="back"/><arc id="d" source="back" target="p"/>
</page></net></pnml>
"""
XMI = """<pn:Net xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:pn="http://dineros.org/pn/1.0" id="n">
<pages id="g">
<objects xsi:type="pn:Place" id="p" tokens="1"/><objects xsi:type="pn:Place" id="q"/>
<objects xsi:type="pn:Transition" id="t"><interval INTERVAL/></objects>
<objects xsi:type="pn:Transition" id="back"><interval earliest="0" latest="0"/></objects>
<arcs id="a" source="p" target="t"/><arcs id="b" source="t" target="q"/>
<arcs id="c" source="q" target="back"/><arcs id="d" source="back" target="p"/>
</pages></pn:Net>
"""


def delay(first: str, second: str, closure: str = "closed") -> str:
    """Return an interval as TINA writes it into PNML."""
    space = "http://www.w3.org/1998/Math/MathML"
    return f'<interval xmlns="{space}" closure="{closure}"><cn>{first}</cn><cn>{second}</cn></interval>'


def bounds(first: str, second: str, more: str = "") -> str:
    """Return an interval of a model."""
    return f'earliest="{first}" latest="{second}" {more}'


BAD = {
    "net": [
        *("[-1,2]", "[3,2]", "]2,2]", "[2,2[", f"[1,{HUGE}]", "[1,1e30]", "[nan,2]", "[0,NaN]", "[0,inf]"),
        *("[w,w[", "[0,w]", "[1]", "[1,2", "[,2]", "[0.000001,1000000000]"),
    ],
    "pnml": [
        *(delay("-1", "2"), delay("3", "2"), delay("2", "2", "open"), delay("1", HUGE), delay("1", "1e30")),
        *(delay("1", "1e400"), delay("NaN", "2"), delay("0", "NaN"), delay("inf", "2"), delay("one", "2")),
        *(delay("", "2"), delay("1", "2", "shut"), "", delay("1", "2") * 2),
    ],
    "xmi": [
        *(bounds("-1", "2"), bounds("3", "2"), bounds("2", "2", 'latestExcluded="true"'), bounds("1", HUGE)),
        *(bounds("1", "1e30"), bounds("1", "1e400"), bounds("nan", "2"), bounds("1", "NaN")),
        *(bounds("1", "inf"), bounds("inf", "2"), bounds("x", "2"), bounds("", "2")),
    ],
}
ZERO = {"net": "[0,0]", "pnml": delay("0", "0"), "xmi": bounds("0", "0")}


def written(folder: Path, kind: str, interval: str) -> Path:
    """Write a net with an interval."""
    text = {"net": NET, "pnml": PNML, "xmi": XMI}[kind]
    path = folder / f"bad.{kind}"
    path.write_text(text.replace("INTERVAL", interval).replace("NOW", delay("0", "0")))
    return path


@pytest.mark.parametrize(("kind", "interval"), [(kind, one) for kind, bad in BAD.items() for one in bad])
def test_one_line(run: Run, tmp_path: Path, kind: str, interval: str) -> None:
    done = run("statespace", str(written(tmp_path, kind, interval)), "--time")
    assert (done.exit_code, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(f"{tmp_path}/bad.{kind}:")


@pytest.mark.parametrize("kind", ZERO)
def test_a_loop_in_no_time_is_found(run: Run, tmp_path: Path, kind: str) -> None:
    path = written(tmp_path, kind, ZERO[kind])
    assert run("statespace", str(path), "--time").exit_code == 0
    done = run("check", str(path), "--time")
    assert done.exit_code == 1
    assert "[time-stops]" in done.stdout
