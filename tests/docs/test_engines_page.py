"""The table of reduction rules in the guide says what the rules say."""

from __future__ import annotations

import re
from pathlib import Path

from dineros.analysis.reductions import RULES, Property

PAGE = (Path(__file__).resolve().parents[2] / "docs/engines.md").read_text(encoding="utf-8")
COLUMNS = list(Property)


def test_the_table_holds_every_rule_and_what_it_can_preserve() -> None:
    rows = re.findall(r"^\| `(\w+)` \| .+? \|((?: (?:yes|some)? ?\|){7})$", PAGE, flags=re.MULTILINE)
    shown = {
        rule: {column for column, cell in zip(COLUMNS, cells.split("|"), strict=False) if cell.strip()}
        for rule, cells in rows
    }
    assert shown == {rule.name: set(rule.preserves) for rule in RULES}


def test_every_property_is_explained() -> None:
    assert re.findall(r"^\| `(\w+)` \| [^|]+ \|$", PAGE, flags=re.MULTILINE) == [
        str(kept) for kept in COLUMNS
    ]
