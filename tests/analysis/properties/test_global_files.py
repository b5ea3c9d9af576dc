"""Questions of any net in property files: by their ids, and as formulas that say the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from hypothesis import given, settings

from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property, recognised
from dineros.analysis.properties.reading import read_properties
from dineros.analysis.properties.writing import write_properties
from tests.analysis.covering.plain import plain_search
from tests.analysis.strategies import nets

ASKED = [Property(name, "global", examination=name) for name in GLOBAL_PROPERTIES]


@settings(max_examples=15, deadline=None)
@given(nets())
def test_they_are_recognised_by_their_ids_and_their_formulas_say_the_same(net: CompiledNet) -> None:
    if not plain_search(net, 300).is_complete:
        return
    names = GroupedNames(NetNames(net))
    with TemporaryDirectory() as folder:
        file = Path(folder, "all.xml")
        write_properties(file, ASKED, net, names)
        by_id = [recognised(one, net) for one in read_properties(file, names)]
        text = file.read_text(encoding="utf-8")
        for number, name in enumerate(GLOBAL_PROPERTIES):  # ids that say nothing
            text = text.replace(f"<id>{name}</id>", f"<id>{number}</id>")
        file.write_text(text, encoding="utf-8")
        formulas = read_properties(file, names)
    assert by_id[1:] == ASKED[1:]  # a deadlock is a formula of the contest's own
    assert {recognised(one, net).kind for one in formulas} == {"ctl"}
    told = [replace(one, id=f"again {one.id}") for one in formulas]
    answers = [each.value for each in answer_properties(net, names, [*ASKED, *told], seconds=5)]
    assert None not in answers
    assert answers[:5] == answers[5:]
