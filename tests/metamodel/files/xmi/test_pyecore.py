"""Files that pyecore's own XMI resource and ours exchange hold equal models."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyecore.resources import URI, ResourceSet
from pyecore.resources.xmi import XMIOptions

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.files.schema import PACKAGES
from dineros.metamodel.files.xmi import read_xmi, write_xmi
from tests.support.equality import differences
from tests.support.systems.models import plain_nets, system_models


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pyecore")


def resources() -> ResourceSet:
    known = ResourceSet()
    known.metamodel_registry.update(PACKAGES)
    return known


models = st.one_of(plain_nets(), system_models(with_properties=True))


@pytest.mark.long
@given(model=models)
def test_pyecore_reads_what_we_write(folder: Path, model: pn.Net) -> None:
    write_xmi(model, folder / "ours.xmi")
    theirs: EObject = resources().get_resource(URI(str(folder / "ours.xmi"))).contents[0]
    assert differences(model, theirs) == []


@pytest.mark.long
@given(
    model=models, options=st.sampled_from([{}, {XMIOptions.OPTION_USE_XMI_TYPE: True}]), uuids=st.booleans()
)
def test_we_read_what_pyecore_writes(
    folder: Path, model: pn.Net, options: dict[XMIOptions, bool], uuids: bool
) -> None:
    resource = resources().create_resource(URI(str(folder / "theirs.xmi")))
    resource.use_uuid = uuids
    resource.append(model)
    resource.save(options=options)
    assert differences(read_xmi(folder / "theirs.xmi"), model) == []
