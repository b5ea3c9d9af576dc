"""Signals whose source is silent: detected after a configured time, with a configured reaction.

A net cannot distinguish a broken cable, a crashed sensor and a lost broker: the last value stays. So the
source of an important signal repeats its value, and the net defines how long the source may be silent.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from dineros.metamodel.clauses import SignalSetting, setting_text
from dineros.metamodel.errors import DinerosError
from dineros.runtime.scheduling.loop import Loop
from dineros.runtime.scheduling.timers import Timer

LOG = logging.getLogger("dineros.runtime")

WhenStale = Literal["keep", "stop"] | SignalSetting
"""The treatment of a stale signal: it keeps its value, the net stops, or it gets this value."""


class StalenessError(DinerosError):
    """The time or the reaction for stale signals is invalid."""


@dataclass(frozen=True)
class Expectation:
    """How long a signal's source may be silent, and the reaction.

    Attributes
    ----------
    seconds : float
        After so long the signal is stale.
    then : {"keep", "stop"}, bool or str
        ``"keep"``: it keeps its value; ``"stop"``: the net fires nothing more until `Net.proceed`; True,
        False or the name of a value: it gets this value. In each case, this is logged, recorded and shown by
        `Net.inspect`.

    Raises
    ------
    StalenessError
        The time is not positive and finite, or the reaction is unknown.
    """

    seconds: float
    then: WhenStale = "keep"

    def __post_init__(self) -> None:
        if isinstance(self.seconds, bool) or not isinstance(self.seconds, (int, float)):
            raise StalenessError(f"the time of staleness must be a number of seconds, not {self.seconds!r}")
        if not (math.isfinite(self.seconds) and self.seconds > 0):
            raise StalenessError(
                f"a signal cannot be stale after {self.seconds} s", hint="give a time above 0, in seconds"
            )
        if not isinstance(self.then, bool) and not str(self.then).isidentifier():
            raise StalenessError(
                f"a stale signal cannot be handled by {self.then!r}", hint="keep, stop, true or false"
            )

    def require(self, values: tuple[str, ...]) -> None:
        """Refuse a value that a signal cannot have, with `StalenessError`; `values`: its names, if any."""
        known = ("keep", "stop", *(values or (True, False)))
        if self.then not in known:
            hint = (
                f"keep, stop, {', '.join(values[:-1])} or {values[-1]}"
                if values
                else "keep, stop, true or false"
            )
            raise StalenessError(f"a stale signal cannot be handled by {self.then!r}", hint=hint)


def parse_expectation(text: str) -> Expectation:
    """Read ``SECONDS`` or ``SECONDS:THEN``, such as ``2.5:false``.

    Raises
    ------
    StalenessError
        The text has another form.

    Examples
    --------
    >>> parse_expectation("2.5:false")
    Expectation(seconds=2.5, then=False)
    """
    seconds, colon, then = text.partition(":")
    try:
        number = float(seconds)
    except ValueError:
        raise StalenessError(
            f"{seconds!r} is not a time in seconds", hint="such as 2.5 or 2.5:stop"
        ) from None
    return Expectation(number, parse_then(then) if colon else "keep")


def parse_then(text: str | bool) -> WhenStale:
    """Read ``keep``, ``stop``, ``true``, ``false`` or the name of a value, which is not checked here."""
    if isinstance(text, bool):
        return text
    word = text.strip()
    plain = word.lower() if word.lower() in ("keep", "stop", "true", "false") else word
    return {"true": True, "false": False}.get(plain, plain)


class Expectations:
    """Watches when the signals of a net were last set; on the thread of its loop.

    Parameters
    ----------
    loop : Loop
        The net's loop with its timers and clock.
    names : sequence of str
        Ids of the signals, for messages.
    set_signals : callable
        Sets signals, by number.
    tell_error : callable
        Records an error, with the policy that was applied.
    halt : callable
        Halts the net, for a given reason.
    """

    def __init__(
        self,
        loop: Loop,
        names: tuple[str, ...],
        set_signals: Callable[[Mapping[int, SignalSetting]], None],
        tell_error: Callable[[str, str | None], None],
        halt: Callable[[str], None],
    ) -> None:
        self._loop = loop
        self._set_signals, self._tell_error = set_signals, tell_error
        self._names = names
        self._halt = halt
        self._expected: dict[int, Expectation] = {}
        self._heard: dict[int, float] = {}
        self._timers: dict[int, Timer] = {}
        self._stale: set[int] = set()
        self._is_open = False

    @property
    def stale(self) -> tuple[str, ...]:
        """Ids of the signals whose source is silent."""
        return tuple(self._names[number] for number in sorted(self._stale))

    def limit(self, number: int) -> float | None:
        """Seconds that a signal's source may be silent; None: no limit."""
        expectation = self._expected.get(number)
        return None if expectation is None else expectation.seconds

    def expect(self, number: int, expectation: Expectation | None) -> None:
        """Watch a signal from now on; None: stop watching it."""
        self._drop(number)
        self._stale.discard(number)
        self._expected.pop(number, None)
        if expectation is not None:
            self._expected[number] = expectation
            if self._is_open:
                self._watch(number)

    def begin(self) -> None:
        """Start counting: the node is open."""
        self._is_open = True
        for number in self._expected:
            self._watch(number)

    def end(self) -> None:
        """Stop counting."""
        self._is_open = False
        for number in tuple(self._timers):
            self._drop(number)

    def heard(self, number: int) -> None:
        """Record that a signal was set, even to the same value."""
        if number not in self._expected or not self._is_open:
            return
        if number in self._stale:
            self._stale.discard(number)
            LOG.warning("the signal %s is set again", self._names[number])
            self._watch(number)
        else:
            self._heard[number] = self._loop.clock()

    def _watch(self, number: int) -> None:
        self._heard[number] = self._loop.clock()
        self._arm(number, self._expected[number].seconds)

    def _arm(self, number: int, delay: float) -> None:
        self._timers[number] = self._loop.timers.call_later(delay, lambda: self._look(number))

    def _drop(self, number: int) -> None:
        timer = self._timers.pop(number, None)
        if timer is not None:
            timer.cancel()

    def _look(self, number: int) -> None:
        """Mark a signal as stale after its time; if it was set meanwhile, check again later."""
        expectation = self._expected[number]
        left = self._heard[number] + expectation.seconds - self._loop.clock()
        if left > 0:
            self._arm(number, left)
            return
        self._timers.pop(number, None)
        self._stale.add(number)
        then = expectation.then
        does = {"keep": "it keeps its value", "stop": "the net stops"}.get(
            str(then), f"it becomes {setting_text(then)}"
        )
        text = f"the signal {self._names[number]} is stale: not set for {expectation.seconds:g} s; {does}"
        LOG.error("%s", text)
        self._tell_error(text, "halt" if then == "stop" else None)
        if then not in ("keep", "stop"):
            self._set_signals({number: then})
        elif then == "stop":
            self._halt(text)
