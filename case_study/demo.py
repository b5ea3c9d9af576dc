"""The main job on the case study, step by step, with the commands a user would type.

``make demo`` runs this: validate the model, convert it, flatten it in every signal variant, check it, count
its state space, verify a formula, split it into runtime models, draw a rule. Results lie in ``build/demo``.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MODEL = "case_study/sorting.sym.xmi"
OUTPUT = "build/demo"
TEN_OF_EACH = " ".join(f"--set {color}Objects.tokens=10" for color in ("Red", "Blue", "Green"))
COMMANDS = [
    ("The model keeps every constraint", f"validate {MODEL}"),
    ("The same model as PNML", f"convert {MODEL} -o {OUTPUT}/sorting.pnml"),
    *(
        (
            f"A plain net, signals {variant}",
            f"flatten {MODEL} --signals {variant} -o {OUTPUT}/sorting.{variant}.pnm.xmi",
        )
        for variant in ("none", "input-enabled", "io-enabled", "fully-enabled")
    ),
    ("What became of one transition", f"flatten {MODEL} --explain Pick[2].PickRun"),
    ("Nothing is wrong with it: no queue overflows, nothing is dead", f"check {MODEL} -v"),
    ("What capacity each queue needs", f"check {MODEL} --suggest-capacities"),
    ("Its complete state space, ten objects of each colour", f"statespace {MODEL} {TEN_OF_EACH}"),
    (
        "Every state can still finish all three objects",
        f"verify {MODEL} --signals none --ctl 'AG EF (Shown >= 3)'",
    ),
    ("A runtime model per ROS node", f"split {MODEL} -o {OUTPUT}/runtime"),
    ("A rule of the paper, drawn", f"rules T2 -o {OUTPUT}/T2.svg"),
]


def main() -> int:
    """Run the commands; stop at the first that fails."""
    (ROOT / OUTPUT).mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    for title, command in COMMANDS:
        print(f"\n== {title}\n$ dineros {command}", flush=True)
        arguments = [sys.executable, "-m", "dineros.cli.main", *shlex.split(command)]
        status = subprocess.run(arguments, cwd=ROOT, check=False).returncode
        if status:
            print(f"exit status {status}", file=sys.stderr)
            return status
    print(f"\nAll of it in {time.perf_counter() - start:.1f} s; the files are in {OUTPUT}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
