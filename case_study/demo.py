"""The main job on the case study, step by step, with the commands a user would type.

``make demo`` runs this: verify the model, generate the ROS 2 workspace around the handlers of
`case_study/workspace`, run its six nodes and a simulated cell as processes of their own while a human walks
in and out, and compare what happened with the model. Results lie in ``build/demo``. If interfaces cannot
be built, the same runs in one process.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MODEL = "case_study/sorting.sym.xmi"
OUTPUT = "build/demo"
WORKSPACE = f"{OUTPUT}/workspace"
TRACES = f"{OUTPUT}/traces"
OBJECTS = {"Red": 2, "Blue": 2, "Green": 2}
SORTED = " ".join(f"--set {color}Objects.tokens={number}" for color, number in OBJECTS.items())
TEN_OF_EACH = " ".join(f"--set {color}Objects.tokens=10" for color in OBJECTS)
UNTIL = f"Shown >= {sum(OBJECTS.values())}"
ONE_ARM = "PickRun + PlaceRun <= 1"
PICTURE = ("The model, drawn", f"convert {MODEL} -o {OUTPUT}/sorting.html")

VERIFYING = [
    ("The model keeps every constraint", f"validate {MODEL}"),
    ("A plain net, made by the rules", f"flatten {MODEL} -o {OUTPUT}/sorting.pnm.xmi"),
    (
        "Nothing is wrong with it: no queue overflows, nothing is dead",
        f"check {MODEL} -o {OUTPUT}/check.html",
    ),
    ("What capacity each queue needs", f"check {MODEL} --suggest-capacities"),
    ("Its complete state space, ten objects of each colour", f"statespace {MODEL} {TEN_OF_EACH}"),
    ("In no state do two arms move", f"verify {MODEL} --signals none --ltl 'G ({ONE_ARM})'"),
    (
        "Every state can still finish all three objects",
        f"verify {MODEL} --signals none --ctl 'AG EF (Shown >= 3)'",
    ),
    PICTURE,
]
GENERATING = [
    (
        "A ROS 2 package per node, around the handlers that are there",
        f"generate {MODEL} {SORTED} -o {WORKSPACE}",
    ),
]
ON_ROS = (
    "Six nodes and a simulated cell on ROS 2; a human walks in twice",
    f"run {WORKSPACE} --with 'python -m sorting_cell --visit 3 --visit 7' --until '{UNTIL}' --timeout 120 "
    f"--trace {TRACES} --reach memory",
)
IN_PROCESS = (
    "The same in one process, since this machine cannot build ROS interfaces",
    f"run {MODEL} {SORTED} --local --until '{UNTIL}' --timeout 120 --trace {TRACES}",
)
AFTERWARDS = [
    (
        "What happened is allowed by the model, and never did two arms move",
        f"conform {MODEL} {SORTED} {TRACES} --invariant '{ONE_ARM}'",
    ),
    ("What happened, drawn", f"trace {TRACES} --model {MODEL} {SORTED} -o {OUTPUT}/run.html"),
]


def main() -> int:
    """Run the commands in a ROS domain of their own; stop at the first that fails."""
    from dineros.runtime.ros.process.domains import claimed_domain

    with claimed_domain() as domain:
        return run_all({**os.environ, "ROS_DOMAIN_ID": str(domain)})


def run_all(environment: Mapping[str, str]) -> int:
    """Run the commands; stop at the first that fails, but for the picture.

    Parameters
    ----------
    environment
        Variables of the processes.
    """
    start = time.perf_counter()
    shutil.rmtree(ROOT / OUTPUT, ignore_errors=True)
    (ROOT / OUTPUT).mkdir(parents=True)
    shutil.copytree(
        ROOT / "case_study/workspace",
        ROOT / WORKSPACE,
        ignore=shutil.ignore_patterns("build", "install", "log", "__pycache__"),
    )
    lacking = missing_tools()
    if lacking:
        print(f"This machine lacks what ROS interfaces are built with: {', '.join(lacking)}")
    run = IN_PROCESS if lacking else ON_ROS
    for title, command in [*VERIFYING, *GENERATING, run, *AFTERWARDS]:
        print(f"\n== {title}\n$ dineros {command}", flush=True)
        arguments = [sys.executable, "-P", "-m", "dineros.cli.main", *shlex.split(command)]
        status = subprocess.run(arguments, cwd=ROOT, check=False, env=environment).returncode
        if status and (title, command) != PICTURE:  # the main job is the same without it
            print(f"exit status {status}", file=sys.stderr)
            return status
    report(time.perf_counter() - start)
    return 0


def missing_tools() -> list[str]:
    """Return what is missing for a run on ROS 2; DINEROS_DEMO_WITHOUT_ROS=1 says that it is."""
    from dineros.generators.workspace.building import missing_tools

    if os.environ.get("DINEROS_DEMO_WITHOUT_ROS"):
        return ["nothing, but you asked for a run without ROS"]
    return missing_tools()


def report(seconds: float) -> None:
    """Say what the run came to, and where the pictures are."""
    from dineros.metamodel.records import Fire, Signal, node_traces, read_trace

    shown, given_up, visits = [], 0, 0
    for files in node_traces(ROOT / TRACES).values():
        for record in read_trace(files):
            if isinstance(record, Fire) and record.transition == "TShowResult":
                shown += [token.data for tokens in record.made.values() for token in tokens]
            elif isinstance(record, Fire):
                given_up += record.transition.endswith("Abort")
            elif isinstance(record, Signal):
                visits += record.signal == "Danger" and record.value is True
    print("\n== Report")
    for data in shown:
        errors = "; ".join(json.dumps(error) for error in data["errors"])  # type: ignore[union-attr]
        outcome = "sorted" if data["placeSuccess"] else "not sorted"
        print(f"{data['name']}: {outcome}{f', after {errors}' if errors else ''}")
    print(f"Human walked in: {visits}; motions given up for that: {given_up}.")
    print("The run conforms to the model; in none of its states did two arms move.")
    for file, what in (
        ("sorting.html", "the model"),
        ("check.html", "what was verified"),
        ("run.html", "the run, to be walked through step by step"),
    ):
        if (ROOT / OUTPUT / file).exists():
            print(f"{OUTPUT}/{file}: {what}")
    print(f"All of it in {seconds:.1f} s")


if __name__ == "__main__":
    sys.exit(main())
