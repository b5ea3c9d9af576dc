"""What models of ROS 2 say is kept in every format."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import load, save
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml
from dineros.metamodel.files.pnml.vocabulary import Version
from tests.support.equality import differences
from tests.support.ros2_systems.executor_models import executor_models


@pytest.mark.long
@given(executor_models(), st.sampled_from(["0.1", "0.2"]))
@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
def test_nothing_is_lost_in_files(tmp_path: Path, model: sym.SystemModel, version: Version) -> None:
    (tmp_path / "model.pnml").write_bytes(pnml_bytes(model, version))
    assert differences(model, read_pnml(tmp_path / "model.pnml")) == []
    save(model, tmp_path / "model.sym.xmi")
    assert differences(model, load(tmp_path / "model.sym.xmi")) == []


def test_capacities_of_plain_nets(tmp_path: Path) -> None:
    net = pn.Net(id="plain")
    page = pn.Page(id="page", net=net)
    flow(pn.Place(id="Box", tokens=1, capacity=2, page=page), pn.Transition(id="Take", page=page))
    for name in ("plain.xmi", "plain.pnml"):
        save(net, tmp_path / name)
        assert differences(net, load(tmp_path / name)) == []
