"""The lines of source code that a finding is about, for models that were made from code."""

from __future__ import annotations

from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import pn
from dineros.metamodel.elements import elements
from dineros.metamodel.errors import Location
from dineros.metamodel.positions import code_of, line_of


class CodeLines:
    """Finds lines of code for findings.

    `model`: the model; elements that stand for lines of code say so.
    """

    def __init__(self, model: pn.Net) -> None:
        self._by_id = {element.id: element for element in elements(model) if element.id}
        self._knows = any(element.sourceLine for element in self._by_id.values())

    def of(self, finding: Finding) -> list[Location]:
        """Return the lines, the most telling first: where a callback waits, then what the finding names."""
        if finding.lines:
            return [line_of(text) for text in finding.lines]
        if not self._knows:
            return []
        found = [*self._waits(finding), *(code_of(self._by_id.get(id)) for id in finding.elements)]
        return list(dict.fromkeys(each for each in found if each is not None))

    def _waits(self, finding: Finding) -> list[Location | None]:
        """Return the last line that each callback of the finding runs in its witness."""
        if finding.witness is None or not finding.circle:
            return []
        found = []
        for page in finding.elements:
            steps = [
                step.transition for step in finding.witness.steps if step.transition.startswith(f"{page}.")
            ]
            own = [self._by_id[id] for id in steps if id in self._by_id and self._by_id[id].sourceLine]
            found += [code_of(each) for each in own[-1:]]
        return found
