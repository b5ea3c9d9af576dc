"""The input signals in the API for developers."""

from __future__ import annotations

from collections.abc import Callable

from dineros.metamodel.errors import FeatureValueError
from dineros.runtime.nets.staleness import Expectation, WhenStale


class Signal:
    """An input signal of the node.

    Attributes
    ----------
    id : str
        Its id in the model.
    """

    def __init__(
        self,
        id: str,
        read: Callable[[], bool],
        write: Callable[[bool, str], None],
        expect: Callable[[Expectation | None], None],
    ) -> None:
        self.id = id
        self._read = read
        self._write = write
        self._expect = expect

    @property
    def value(self) -> bool:
        """The current value. A value that was set a moment ago may not be applied yet."""
        return self._read()

    def set(self, value: bool, source: str = "program") -> None:
        """Set it; from any thread. The node applies the value at its next opportunity.

        Parameters
        ----------
        value : bool
            The value.
        source : str
            Origin of the value, for the records.

        Raises
        ------
        FeatureValueError
            The value is neither True nor False.
        """
        if not isinstance(value, bool):
            raise FeatureValueError(f"the signal {self.id} takes True or False, not {value!r}")
        self._write(value, source)

    def stale_after(self, seconds: float | None, then: WhenStale = "keep") -> None:
        """Detect that its source is silent, from any thread; time counts while the node is open.

        The source must then repeat the value, even if it does not change.

        Parameters
        ----------
        seconds : float or None
            None: it may be silent without limit, which is the default.
        then : {"keep", "stop"} or bool
            Reaction: keep the value, halt the net (see `Net.proceed`), or set this value.

        Raises
        ------
        StalenessError
            The time is not positive, or `then` is none of these.
        """
        self._expect(None if seconds is None else Expectation(seconds, then))

    def __repr__(self) -> str:
        return f"<Signal {self.id} {self.value}>"
