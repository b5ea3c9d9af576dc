"""Compare flattened nets of generated models with the interpreter of system models under ROS 2.

``python -m tests.histories --models 300 --seed 1`` draws models, flattens each in every variant of signals
and with both encodings of overflow, and walks net and interpreter together. It prints how much was compared,
and ends with 1 where they differ.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from typing import get_args

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.histories.comparing import features_of_model, variants
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models

FAMILIES = {
    "histories": history_models,
    "executors": executor_models,
    "actions": action_models,
    "lifecycles": lifecycle_models,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--states", type=int, default=2000, help="states of a net that are compared")
    parser.add_argument("--only", choices=FAMILIES, help="models of one kind")
    arguments = parser.parse_args()
    usual = st.one_of(executor_models(), *(each() for each in FAMILIES.values()))
    totals: Counter[str] = Counter()
    differences = []

    @seed(arguments.seed)
    @settings(
        max_examples=arguments.models,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(FAMILIES[arguments.only]() if arguments.only else usual)
    def every(model: sym.SystemModel) -> None:
        totals["models"] += 1
        totals.update(features_of_model(model))
        for signals, overflow, found in variants(
            model, arguments.states, get_args(SignalVariant), get_args(OverflowVariant)
        ):
            totals["nets"] += 1
            totals["states"] += found.states
            totals["steps"] += found.steps
            totals["nets compared in part"] += not found.complete
            if found.difference:
                differences.append(f"{signals}, {overflow}: {found.difference}")

    every()
    for what, number in sorted(totals.items()):
        print(f"{number:9} {what}")
    print(f"{len(differences):9} differences")
    for difference in differences[:10]:
        print(f"  {difference}")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
