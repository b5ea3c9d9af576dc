"""The input signals in the API for developers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.runtime.nets.ports import SignalPort
from dineros.runtime.nets.staleness import Expectation, WhenStale


class Signal:
    """An input signal of the node.

    Attributes
    ----------
    id : str
        Its id in the model.
    values : tuple of str
        The names of its values; none: it is true or false.
    """

    def __init__(
        self,
        port: SignalPort,
        read: Callable[[], Any],
        write: Callable[[SignalSetting, str], None],
        expect: Callable[[Expectation | None], None],
    ) -> None:
        self.id, self.values = port.id, port.values
        self._port = port
        self._read = read
        self._write = write
        self._expect = expect

    @property
    def value(self) -> Any:
        """A boolean, or the name of a value. One that was set a moment ago may not have come through yet."""
        return self._read()

    def set(self, value: SignalSetting, source: str = "program") -> None:
        """Set it; from any thread. It counts once the node comes round to it, which is soon.

        Parameters
        ----------
        value : bool or str
            The value; the name of one if the signal has values.
        source : str
            Origin of the value, for the records.

        Raises
        ------
        FeatureValueError
            It is not one of its values, or neither True nor False.
        """
        self._port.require(value)
        self._write(value, source)

    def stale_after(self, seconds: float | None, then: WhenStale = "keep") -> None:
        """Detect that its source is silent, from any thread; time counts while the node is open.

        The source must then repeat the value, even if it does not change.

        Parameters
        ----------
        seconds : float or None
            None: it may be silent forever, as at first.
        then : {"keep", "stop"}, bool or str
            What is done: it keeps its value, the net stops (see `Net.proceed`), or it gets this value.

        Raises
        ------
        StalenessError
            The time is not positive, or `then` is unknown.
        """
        self._expect(None if seconds is None else Expectation(seconds, then))

    def __repr__(self) -> str:
        return f"<Signal {self.id} {self.value}>"
