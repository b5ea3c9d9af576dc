"""Chooses the next transition to fire: uniformly at random, or by the developers' selection function."""

from __future__ import annotations

from random import Random

from dineros.runtime.firing.selection import Candidates, Enabled, SelectionFunction, chosen_tokens
from dineros.runtime.firing.timing import Timing
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.scheduling.watchdog import Watchdog


class Chooser:
    """Chooses among the ready transitions of an engine.

    Parameters
    ----------
    random : Random
        Draws a transition if there is no selection function.
    timing : Timing
        Determines which ready transitions may fire now.
    watchdog : Watchdog
        Watches the selection.

    Attributes
    ----------
    selection : callable or None
        The developers' selection; None: uniformly at random.
    is_paused : bool
        Whether the selection is suspended after a failure.
    failures : int
        Number of failures of the selection since its last success.
    """

    def __init__(self, random: Random, timing: Timing, watchdog: Watchdog) -> None:
        self.selection: SelectionFunction | None = None
        self.is_paused = False
        self.failures = 0
        self._random = random
        self._timing = timing
        self._watchdog = watchdog

    def choose(self, engine: Engine) -> tuple[int, Tokens | None] | None:
        """Return a transition and its tokens (None: the oldest ones); or None if nothing is to fire.

        Raises
        ------
        BaseException
            Any error that the selection raised.
        SelectionError
            The selection returned something that cannot fire.
        """
        ready, selection = engine.ready, self.selection  # other threads may set it
        if not ready or (self.is_paused and selection is not None):
            self.pass_time(engine)
            return None
        if selection is not None:
            return self._selected(engine, selection)
        if engine.prioritised or self._timing:
            ready = self._allowed(engine)
            if not ready:
                return None
        size = len(ready)
        return (ready[0] if size == 1 else ready[int(self._random.random() * size)]), None

    def pass_time(self, engine: Engine) -> None:
        """Update the clocks of ready transitions while nothing is to fire."""
        if self._timing:
            self._timing.of(engine, [])

    def _allowed(self, engine: Engine) -> list[int]:
        """Return the ready transitions that may fire by priority and time."""
        if self._timing:
            return self._timing.of(engine, engine.ready)
        return [number for number in engine.ready if not engine.is_overridden(number)]

    def _selected(self, engine: Engine, selection: SelectionFunction) -> tuple[int, Tokens] | None:
        allowed = sorted(self._allowed(engine))
        if not allowed:
            return None
        candidates = Candidates([Enabled(engine, number) for number in allowed], self._random)
        name = getattr(selection, "__name__", "selection")
        chosen = chosen_tokens(engine, candidates, self._watchdog.call(selection, candidates, name))
        self.failures = 0
        return chosen
