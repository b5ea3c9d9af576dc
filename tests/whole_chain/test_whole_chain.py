"""A few generated models, always the same, on their way; `python -m tests.whole_chain` takes hundreds."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from tests.fuzz.judging import Outcome, run_command
from tests.generators.models import kitchen
from tests.whole_chain import chain
from tests.whole_chain.chain import empty, take_through
from tests.whole_chain.models import broken_models, whole_models

FEW = settings(
    max_examples=4,
    deadline=None,
    derandomize=True,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
SEEDS = st.integers(0, 2**16)


@pytest.mark.long
@given(whole_models(), SEEDS)
@FEW
def test_whole_models(tmp_path: Path, model: sym.SystemModel, seed: int) -> None:
    assert take_through(model, empty(tmp_path / "model"), seed).faults == []


@pytest.mark.long
@given(broken_models(), SEEDS)
@settings(FEW, max_examples=4)
def test_broken_models(tmp_path: Path, model: sym.SystemModel, seed: int) -> None:
    assert take_through(model, empty(tmp_path / "model"), seed).faults == []


def test_faults_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the chain is given another model for the replay, the run differs from it."""

    def swapped(*arguments: object) -> Outcome:
        if arguments[0] == "conform":
            arguments = (*arguments, "--set", "Hungry.tokens=5")
        return run_command(*arguments)

    monkeypatch.setattr(chain, "run_command", swapped)
    passage = take_through(kitchen(), empty(tmp_path / "model"))
    assert {fault.partition(":")[0] for fault in passage.faults} == {"conform simulate", "conform local"}
