"""What the editor takes of the processor: opening a model, and answering a command with all marks."""

from __future__ import annotations

import json
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.editing import Document
from dineros.metamodel.files import load, save
from dineros.views.editing.session import Session

CASE_STUDY = Path(__file__).resolve().parents[2] / "case_study/sorting.sym.xmi"
PAIRS = 250
ANSWERS = 20


def line() -> sym.SystemModel:
    """Return a ROS node with 250 places and 250 transitions in a line, all of them placed."""
    node = sym.NodeNet(id="node")
    nodes: list[pn.Node] = []
    for number in range(PAIRS):
        nodes += [sym.Place(id=f"p{number}"), sym.Transition(id=f"t{number}")]
    for number, each in enumerate(nodes):
        each.graphics = pn.Graphics(positions=[pn.Point(x=80 * (number % 30), y=90 * (number // 30))])
    node.objects.extend(nodes)
    flow(*nodes)
    return sym.SystemModel(id="line", pages=[node])


def timed(work: Callable[[], object]) -> float:
    """Return how much processor time something takes, in seconds."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def measure(name: str, model: pn.Net, place: str) -> None:
    """Print what a model takes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.sym.xmi"
        save(model, file)
        found: list[Session] = []
        opening = timed(lambda: found.append(Session(Document(file))))
        (session,) = found
        greeting = timed(session.greeting)
        document = session.document
        element = next(each for each in document.root.eAllContents() if getattr(each, "id", None) == place)
        command = {"kind": "set", "element": document.handles.of(element), "feature": "tokens"}
        answers = []
        for number in range(1, ANSWERS + 1):
            asked = {"number": number, "ask": "do", "commands": [{**command, "value": -number}]}
            answers.append(timed(partial(session.hear, json.dumps(asked), "page")))
        document.close()
    print(
        f"{name}: open {opening:.3f} s, snapshot {greeting:.3f} s, "
        f"an answer {statistics.median(answers) * 1000:.1f} ms (slowest {max(answers) * 1000:.1f} ms)"
    )


def main() -> None:
    """Measure and print."""
    measure("case study", load(CASE_STUDY), "RedObjects")
    measure("500 places and transitions", line(), "p7")


if __name__ == "__main__":
    main()
