"""Models to draw."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from case_study.build import build
from dineros.metamodel import elements, pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker

EDITED = Path(__file__).with_name("edited.pnml")


@cache
def case_study() -> sym.SystemModel:
    return build()


def models() -> dict[str, pn.Net]:
    """Return models of every kind by name."""
    study = case_study()
    return {
        "case study": study,
        "talker": talker(),
        "every sign": every_sign(),
        "arranged": arranged(),
        **{f"runtime {model.id}": model for model in split(study)},
    }


def every_sign() -> pn.Net:
    """Return a net with all kinds of arcs, weights, many tokens, names that need escaping, nested pages."""
    few, many = pn.Place(id="few", name="<few> & 'so'", tokens=3), pn.Place(id="many", tokens=1234)
    none = pn.Place(id="none", name="a very long name of a place that holds nothing")
    go = pn.Transition(id="go", interval=pn.TimeInterval(earliest=1, latest=2))
    outer, inner = pn.Page(id="outer", objects=[few, many, none, go]), pn.Page(id="inner", name='"inner"')
    outer.objects.append(inner)
    again, stop = pn.ReferencePlace(id="again", target=few), pn.Transition(id="stop", overrides=[go])
    inner.objects.extend([again, stop])
    flow(few, go, weight=12)
    flow(go, many)
    read(many, go)
    inhibit(none, go, weight=2)
    flow(again, stop, again)
    return pn.Net(id="signs", pages=[outer, pn.Page(id="empty")])


def arranged() -> pn.Net:
    """Return a net that an editor arranged, apart from one place."""

    def at(x: float, y: float) -> pn.Graphics:
        return pn.Graphics(positions=[pn.Point(x=x, y=y)])

    a, t = pn.Place(id="a", tokens=1, graphics=at(100, 100)), pn.Transition(id="t", graphics=at(160, 100))
    b, u = pn.Place(id="b", graphics=at(160, 190)), pn.Transition(id="u", graphics=at(100, 190))
    late = pn.Place(id="late")
    page = pn.Page(id="page", objects=[a, t, b, u, late])
    flow(a, t, b, u, a)
    flow(t, late)
    page.arcs[0].graphics = pn.Graphics(positions=[pn.Point(x=130, y=60)])
    return pn.Net(id="arranged", pages=[page])


STUDY = {
    "selector": (150, 150),
    "controller": (760, 150),
    "synchronizer": (1350, 150),
    "executor": (1050, 520),
    "sensorics": (1500, 520),
    "feedback": (150, 520),
    "LeftCellObjects": (450, 80),
    "RightCellObjects": (450, 220),
    "UITopic": (450, 520),
    "Pick": (700, 400),
    "Place": (950, 330),
    "SensorService": (1300, 520),
    "GetControl": (1050, 80),
}


def arranged_study(apart: float = 1.0) -> sym.SystemModel:
    """Return the case study with positions of its ROS nodes and of all channels but one."""
    model = build()
    for id, (x, y) in STUDY.items():
        point = pn.Point(x=x * apart, y=y * apart)
        elements.find(model, id).graphics = pn.Graphics(positions=[point])
    return model
