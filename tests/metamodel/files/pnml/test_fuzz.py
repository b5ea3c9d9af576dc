"""However a PNML file is damaged, reading gives a model or one clear error."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.pnml import pnml_bytes, read_pnml
from tests.support.equality import differences
from tests.support.systems.models import plain_nets, system_models
from tests.support.systems.odd_models import odd_models

VALUES = st.sampled_from(
    ["", " ", "-1", "0", "99999999999", "1e400", "nan", "x", "root", "pn.Arc", "sym.NodeNet"]
)


@pytest.mark.long
@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(net=st.one_of(plain_nets(), system_models(with_properties=True), odd_models()), data=st.data())
def test_damaged_files(net: object, data: st.DataObject, tmp_path: Path) -> None:
    root = etree.fromstring(pnml_bytes(net, data.draw(st.sampled_from(["0.1", "0.2"]))))  # type: ignore[arg-type]
    for _ in range(data.draw(st.integers(1, 3))):
        _damage(root, data)
    file = tmp_path / "damaged.pnml"
    file.write_bytes(etree.tostring(root))
    try:
        read = read_pnml(file)
    except DinerosError as error:
        assert str(error).startswith(str(file))
        assert "\n" not in str(error)
        return
    file.write_bytes(pnml_bytes(read))
    assert not differences(read, read_pnml(file))


def _damage(root: etree._Element, data: st.DataObject) -> None:
    """Change, delete, repeat or move one element somewhere in the file."""
    elements = list(root.iter(etree.Element))
    xml, other = data.draw(st.sampled_from(elements)), data.draw(st.sampled_from(elements))
    parent = xml.getparent()
    ids = [str(each.get("id")) for each in elements if each.get("id")] or ["x"]
    match data.draw(st.sampled_from(["text", "attribute", "tag", "delete", "repeat", "move", "own"])):
        case "text":
            xml.text = data.draw(VALUES | st.sampled_from(ids))
        case "attribute" if xml.attrib:
            name = data.draw(st.sampled_from(sorted(map(str, xml.attrib))))
            xml.set(name, data.draw(VALUES | st.sampled_from(ids)))
        case "tag":
            xml.tag = other.tag
        case "delete" if parent is not None:
            parent.remove(xml)
        case "repeat" if parent is not None:
            parent.append(etree.fromstring(etree.tostring(xml, with_tail=False)))
        case "move" if parent is not None and xml not in other.iterancestors() and other is not xml:
            other.append(xml)
        case "own":
            xml.set(
                data.draw(st.sampled_from(["class", "kind", "half", "ref", "page", "signals"])),
                data.draw(VALUES),
            )
