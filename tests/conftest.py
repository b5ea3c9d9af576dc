"""Hypothesis profiles: CI draws the same examples in every run; no test fails because a machine is slow."""

import os

from hypothesis import settings

from dineros.cli.analysing import QUIET_COMPILATION

settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

# What commands print on stderr must not depend on which test is the first one after an installation.
os.environ[QUIET_COMPILATION] = "1"
