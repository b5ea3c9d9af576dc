"""Take generated models through all commands: ``python -m tests.whole_chain --models 200 --seed 1``.

Half of them are whole, half are broken somewhere. It prints how often each command ended how, and what models
were refused for, and ends with 1 where something went wrong; such models are kept in ``build/whole_chain``.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from tests.histories.comparing import features_of_model
from tests.whole_chain.chain import empty, take_through
from tests.whole_chain.models import broken_models, whole_models

FAULTS = Path("build/whole_chain")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=["whole", "broken"], help="only these")
    parser.add_argument(
        "--shrink", action="store_true", help="end with the smallest model of the first fault"
    )
    arguments = parser.parse_args()
    totals: Counter[str] = Counter()
    refused: Counter[str] = Counter()
    faults: list[str] = []
    kinds = {"whole": whole_models(), "broken": broken_models()}
    strategies = [kinds[arguments.kind]] if arguments.kind else list(kinds.values())

    with tempfile.TemporaryDirectory(prefix="dineros-chain-") as place:

        @seed(arguments.seed)
        @settings(
            max_examples=arguments.models,
            deadline=None,
            database=None,
            phases=[Phase.generate, *([Phase.shrink] if arguments.shrink else [])],
            suppress_health_check=list(HealthCheck),
        )
        @given(st.one_of(strategies))
        def every(model: sym.SystemModel) -> None:
            totals["models"] += 1
            passage = take_through(model, empty(Path(place) / "model"), totals["models"])
            totals.update(passage.counts())
            if passage.is_valid:
                totals.update(features_of_model(model))
            refused.update({_shape(said) for said in passage.said.values()})
            if passage.faults:
                path = FAULTS / f"{arguments.seed}-{totals['models']}"
                shutil.copytree(Path(place) / "model", path, dirs_exist_ok=True)
                faults.extend(f"{path}: {fault}" for fault in passage.faults)
                print(*faults[-len(passage.faults) :], sep="\n", flush=True)
                assert not arguments.shrink, passage.faults

        every()
    for what, number in (*sorted(totals.items()), *refused.most_common()):
        print(f"{number:9} {what}")
    print(f"{len(faults):9} faults")
    return 1 if faults else 0


def _shape(said: str) -> str:
    """Return what a refusal says, without names and numbers."""
    text = re.sub(r".*model\.[a-z.]+: *(\d+: *)?|; and \d+ more errors", "", said)
    return re.sub(r"'[^']*'|\d+", "_", text)[:160]


if __name__ == "__main__":
    sys.exit(main())
