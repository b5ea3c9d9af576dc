"""What the readers of both languages say and know about loops whose end they do not recognise."""

from __future__ import annotations

UNKNOWN_END = "what ends it is not known"
"""How a loop waits that sleeps until something happens that the reader does not know."""

ONE_VALUE = "no code gives another value to"
"""How the reason begins why a loop never ends: each attribute in its test has one value in the program."""

OF_TIME = r"time|clock|now\b|elapsed|deadline|until"
"""Regular expression of names in tests that hold after some time, without regard to case."""
