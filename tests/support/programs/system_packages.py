"""Tests that need a system package: skipped by its name where it is missing; with CI set they fail."""

import os
import re
import shutil
from pathlib import Path

import pytest

LIST = Path(__file__).resolve().parents[3] / "tools/system-packages.txt"


def missing(*packages: str) -> list[str]:
    """Return which of these packages of ``tools/system-packages.txt`` are not on this machine."""
    lines = LIST.read_text(encoding="utf-8").splitlines()
    proofs = dict(line.split(maxsplit=2)[:2] for line in lines if line and not line.startswith("#"))
    return [name for name in packages if not (shutil.which(proofs[name]) or Path(proofs[name]).exists())]


def require(*packages: str) -> None:
    """Skip the test that runs, or fail it if nothing may be skipped."""
    absent = ", ".join(missing(*packages))
    if absent and os.environ.get("CI"):
        pytest.fail(f"CI is set: {absent} must be there")
    if absent:
        pytest.skip(f"without {absent}")


def require_for(examples: str) -> None:
    """Skip the test that runs if command lines in these examples need a package that is missing."""
    if re.search(r"dineros rules .*\.svg", examples):
        require("graphviz")


def needs(*packages: str) -> pytest.MarkDecorator:
    """Mark tests that need these packages."""
    absent = missing(*packages)
    unless_ci = bool(absent) and not os.environ.get("CI")
    return pytest.mark.skipif(unless_ci, reason=f"without {', '.join(absent)}")
