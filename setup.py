"""List the packages inside the rooms; everything else about the build is in ``pyproject.toml``.

``packages.find`` cannot put the ``dineros.`` prefix before what it finds in a mapped folder.
"""

import tomllib
from pathlib import Path

from setuptools import find_namespace_packages, setup

settings = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
packages = []
for room, folder in settings["tool"]["setuptools"]["package-dir"].items():
    # Folders that hold only data (templates) are packages to setuptools.
    inner = find_namespace_packages(folder, exclude=["*__pycache__"])
    packages += [room, *(f"{room}.{name}" for name in inner)]

setup(packages=packages)
