"""Where two traces part."""

from __future__ import annotations

from dineros.metamodel.records import Fire
from dineros.views.traces.comparing import Divergence, first_divergence
from tests.views.samples import lasso, run
from tests.views.traces.test_building import built


def test_equal_traces_do_not_part() -> None:
    assert first_divergence(built(lasso()), built(lasso())) is None
    assert first_divergence(built(*run().values()), built(*run().values())) is None


def test_the_first_step_that_differs() -> None:
    assert first_divergence(built(lasso()), built(lasso(differs=True))) == Divergence(7, 7)


def test_a_trace_that_ends_earlier() -> None:
    short = lasso()
    short.records = short.records[:4]
    assert first_divergence(built(short), built(lasso())) == Divergence(3, 3)


def test_nodes_of_runs_are_compared_one_by_one() -> None:
    other = run()
    # Another interleaving is no difference, another firing is.
    for record in other["synchronizer"].records:
        object.__setattr__(record, "time", (record.time or 0) + 60)
    assert first_divergence(built(*run().values()), built(*other.values())) is None
    other["controller"].write(Fire, 0.1, transition="TStartPickL", change={"GetResL": -1, "PickReqL": 1})
    parting = first_divergence(built(*run().values()), built(*other.values()))
    assert parting is not None
    assert parting.node == "controller"
