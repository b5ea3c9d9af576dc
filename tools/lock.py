"""Write ``requirements/*.txt``: exact versions of all that is installed, and the hashes of their files.

``pip install --require-hashes`` refuses any other file, wherever it comes from. One lock serves every
supported Python and machine: markers say what only some need, hashes are those of all files of a version.
Versions stay as they are where they still fit; ``--upgrade`` takes the newest.

Usage: ``make lock [UPGRADE=yes]``, which brings uv.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCKS = ROOT / "requirements"
SHADOWS_LARK = "lark-parser"
"""What the wheels of ROS 2 ask for: an old lark, which writes over the files of lark. They run with lark."""


def commands(uv: str, build: str, upgrade: bool) -> dict[str, list[str]]:
    """Return how each lock is made.

    Parameters
    ----------
    uv
        The program.
    build
        A file with what building packages needs.
    upgrade
        Whether newer versions are taken.

    Returns
    -------
    dict
        From each lock's name to the command that writes it, run in the project's root, in this order.
    """
    oldest = "3.11"  # its first release: distributions ship Pythons some patch releases old
    compile_ = [uv, "--no-config", "pip", "compile", "--quiet", "--universal", "--python-version", oldest]
    compile_ += ["--generate-hashes", "--no-annotate", "--no-emit-package", SHADOWS_LARK]
    compile_ += ["--upgrade"] if upgrade else []
    development = "requirements/development.txt"
    return {
        "development": [*compile_, "--all-extras", "-o", development, "pyproject.toml"],
        "build": [*compile_, "-c", development, "-o", "requirements/build.txt", build],
        "maintenance": [*compile_, "--group", "maintenance", "-o", "requirements/maintenance.txt"],
    }


def main(uv: str, *options: str) -> None:
    """Write all locks."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    LOCKS.mkdir(exist_ok=True)
    environment = {**os.environ, "UV_CUSTOM_COMPILE_COMMAND": "make lock"}
    with tempfile.TemporaryDirectory() as folder:
        build = Path(folder, "build.in")
        build.write_text("\n".join(["pip", *settings["build-system"]["requires"]]), encoding="utf-8")
        for command in commands(uv, str(build), upgrade="--upgrade" in options).values():
            subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main(*sys.argv[1:])
