"""One net of the contest in a process of its own: answers are printed as JSON Lines, as they come."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property, PropertyAnswer
from dineros.analysis.properties.reading import read_properties
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel.files import load

#: Part of the memory of the process that its searches may take.
SEARCH_SHARE = 0.7
COUNTS = {
    "STATES": "states",
    "TRANSITIONS": "arcs",
    "MAX_TOKEN_IN_PLACE": "max_tokens_in_place",
    "MAX_TOKEN_PER_MARKING": "max_tokens_in_marking",
}
"""Names of the contest -> of `StateSpace`."""


def main(arguments: list[str] | None = None) -> int:
    """Answer the examinations of the net in a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--examinations", nargs="+", required=True)
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--memory", type=int, required=True)
    given = parser.parse_args(arguments)
    # Budgets look at this clock: what else the machine does costs a question nothing.
    time.perf_counter = time.process_time
    net = compile_net(load(given.folder / "model.pnml"))
    memory = int(given.memory * SEARCH_SHARE)
    if "StateSpace" in given.examinations:
        for id, value in count(net, memory).items():
            say("StateSpace", id, value, "", time.process_time())
    wanted = [name for name in given.examinations if name != "StateSpace"]
    if wanted:
        answer(net, given.folder, wanted, given.seconds, memory)
    return 0


def count(net: CompiledNet, memory: int) -> dict[str, int | None]:
    """Count the state space, by the names of the contest."""
    space = state_space(net, budget=Budget(memory))
    return {id: getattr(space, name) if space.complete else None for id, name in COUNTS.items()}


def answer(net: CompiledNet, folder: Path, wanted: Iterable[str], seconds: float, memory: int) -> None:
    """Answer all properties of some examinations together."""
    names = GroupedNames(NetNames(net))
    examination: dict[str, str] = {}
    properties: list[Property] = []
    for name in wanted:
        found = (
            [Property(name, "global", examination=name)]
            if name in GLOBAL_PROPERTIES
            else read_properties(folder / f"{name}.xml", names)
        )
        properties += found
        examination.update({one.id: name for one in found})

    def tell(found: PropertyAnswer) -> None:
        say(examination[found.id], found.id, found.value, found.technique, found.seconds)

    def stage(name: str) -> None:
        print(f"{time.process_time():7.1f} s {name}", file=sys.stderr, flush=True)

    for one in answer_properties(net, names, properties, seconds, memory, tell, stage):
        if one.value is None:
            tell(one)


def say(examination: str, id: str, value: Any, technique: str, seconds: float) -> None:
    """Print an answer."""
    record = {"examination": examination, "id": id, "value": value, "technique": technique}
    print(json.dumps({**record, "seconds": round(seconds, 2)}), flush=True)


if __name__ == "__main__":
    sys.exit(main())
