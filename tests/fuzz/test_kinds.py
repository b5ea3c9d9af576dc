"""A few inputs of every kind, always the same; `python -m tests.fuzz` tries thousands."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.judging import judge
from tests.fuzz.targets import KINDS
from tests.runtime.bridges.broker import MOSQUITTO
from tests.support.system_packages import require

INPUTS = 60


@pytest.mark.parametrize("name", KINDS)
def test_a_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    if name == "MQTT" and MOSQUITTO is None:
        require("mosquitto")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    kind = KINDS[name]
    with kind.prepared(tmp_path) as (originals, attempt):
        for original in originals:
            verdict = judge(attempt, original, tmp_path)
            assert verdict.fault is None, original
        for number in range(max(2, INPUTS * min(kind.share, 100) // 100)):
            content = kind.input(originals, name, 0, number)
            verdict = judge(attempt, content, tmp_path)
            assert verdict.fault is None, content[:1000]
