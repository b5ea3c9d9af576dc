"""Write ``constraints.txt``: the exact version of everything that pip resolves for some extras, today.

Versions are those that the first Python 3.11 can use: distributions ship Pythons some patch releases old, and
packages ask for patch releases. Run it with Python 3.11, which needs more packages than 3.12.

Usage: ``.venv/bin/python tools/lock.py EXTRA,EXTRA...``
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
HEAD = "# Exact versions for development and CI, written by `make lock`; asked for in pyproject.toml.\n"
OLDEST = "3.11.0"
SOURCE_ONLY = ["empy==3.3.4"]  # pip resolves for other Pythons from wheels only: we make these


def pins(report: dict[str, Any]) -> list[str]:
    """Name each distribution of pip's installation report, without this project, as ``name==version``.

    Parameters
    ----------
    report
        What ``pip install --report`` wrote.

    Returns
    -------
    list of str
        Sorted by name, regardless of case.
    """
    found = [(item["metadata"]["name"], item["metadata"]["version"]) for item in report["install"]]
    found.sort(key=lambda pin: pin[0].lower())
    return [f"{name}=={version}" for name, version in found if name != "dineros"]


def main(extras: str) -> None:
    """Resolve the project with its extras, ignoring what is installed, and write the versions."""
    if sys.version_info[:2] != (3, 11):
        sys.exit("Lock with Python 3.11: make lock PYTHON=python3.11")
    pip = [sys.executable, "-P", "-m", "pip", "--disable-pip-version-check", "--quiet"]
    wanted = ["pip", "setuptools", "--editable", f"{ROOT}[{extras}]"]
    options = ["--dry-run", "--ignore-installed", "--no-build-isolation", "--report", "-"]
    options += ["--python-version", OLDEST, "--only-binary", ":all:"]
    with tempfile.TemporaryDirectory() as wheels:
        subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", wheels, *SOURCE_ONLY], check=True)
        command = [*pip, "install", *options, "--find-links", wheels, *wanted]
        report = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
    lines = "".join(f"{pin}\n" for pin in pins(report))
    (ROOT / "constraints.txt").write_text(HEAD + lines, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
