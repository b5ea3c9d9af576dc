"""Additional faults of a check with times, as data: every check knows these names."""

from __future__ import annotations

from dineros.analysis.checks.check import FAULTS
from dineros.analysis.witnesses.findings import Fault

TOO_LATE = Fault(
    "never-in-time",
    "warning",
    "A transition gets its tokens, but never fires: others always come before its interval begins, or have "
    "priority over it.",
    "transition {transition} gets its tokens, but never fires: others always come before its interval "
    "{interval} begins, or have priority over it",
)
STOPS = Fault(
    "time-stops",
    "error",
    "Transitions that must fire at once fire infinitely often in no time, or priorities keep one that has to "
    "fire from firing.",
    "time can stop: {loop} can fire again and again in no time",
)
HELD = Fault(
    "time-stops",
    "error",
    "Transitions with priority keep one that has to fire from firing, again and again.",
    "time can stop: {loop} can fire again and again, and by priority keep {held} from firing, which has to "
    "fire before time continues",
)
MAY_STOP = Fault(
    "loop-in-no-time",
    "note",
    "Transitions with a latest bound can fire infinitely often in no time, as their intervals begin at 0.",
    "{loop} can fire again and again in no time, as their intervals begin at 0; they need not, so time can "
    "continue",
)
LOCKED = Fault(
    "time-lock",
    "error",
    "A state can be reached in which a transition has to fire, but priorities forbid it.",
    "time can stop: {transitions} have priority over each other, so none of them fires",
)
LOSES_TICKS = Fault(
    "timer-loses-ticks",
    "warning",
    "A timer strikes while its last tick still waits: its callback runs less often than its period says.",
    "the timer of {callback} can lose ticks: it strikes while its last tick still waits",
)
SKIPS_TICKS = Fault(
    "timer-loses-ticks",
    "note",
    LOSES_TICKS.meaning,
    "the timer of {callback} can lose ticks: its callback can begin only in some states",
)

TIMED_FAULTS = FAULTS | {fault.rule: fault for fault in (TOO_LATE, STOPS, MAY_STOP, LOCKED, LOSES_TICKS)}
"""All that a check with times may find, by its rule."""
