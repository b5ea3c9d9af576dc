"""One point of a sweep, and a process that counts points.

The process loads the engines once and forks for every job. So each point has its own process with its own
peak of memory, and a killed one affects no other. It answers with None when it is ready to count, and then
with the figures or an error.
"""

from __future__ import annotations

import signal
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, get_type_hints

from dineros.analysis.answers.apart import Apart, ApartDiedError
from dineros.analysis.answers.budget import DEFAULT_MEMORY, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.processes import die_with
from dineros.analysis.sweeps.grid import Point, SweepError, model_of
from dineros.analysis.sweeps.parts import Part, answer_part
from dineros.metamodel.errors import BudgetError, DinerosError

if TYPE_CHECKING:
    from dineros.analysis.sweeps.parts import PartAnswer


class PointDiedError(Exception):
    """The process of a point was killed."""

    @classmethod
    def of(cls, status: int) -> PointDiedError:
        """Return the error for an exit status, negative for a signal."""
        if status >= 0:
            return cls(f"it ended with status {status}")
        name = signal.Signals(-status).name if -status in list(signal.Signals) else str(-status)
        memory = ", perhaps for lack of memory" if -status == signal.SIGKILL else ""
        return cls(f"it was killed by {name}{memory}")


@dataclass(frozen=True)
class Job:
    """The data that a worker needs to count a point."""

    model: str
    """The model, as XMI."""
    point: Point
    """Settings and options of the flattening."""
    engine: str = "auto"
    """The engine; see `dineros.analysis.questions.state_space`."""
    memory: int | None = None
    """Memory for the engine, in bytes; None: the engine's default."""
    timeout: float | None = None
    """Seconds after which it is given up."""


@dataclass(frozen=True)
class Figures:
    """The figures of a point.

    Attributes
    ----------
    places, transitions : int or None
        Size of the net explored.
    states, arcs, deadlocks : int or None
        Exact counts; for an incomplete exploration, the counts so far. For a reduced net, these are still
        those of the net itself, but arcs are unknown.
    reduced_states : int or None
        Markings of the explored net, if that is a reduced one.
    seconds : float or None
        Wall-clock time of reduction, search for an order, and exploration.
    peak_memory_bytes : int or None
        Peak memory of the point's process, including about 200 MiB of compiled engines.
    complete : bool
        Whether all markings were counted.
    error : str
        Why not.
    """

    places: int | None = None
    transitions: int | None = None
    states: int | None = None
    arcs: int | None = None
    deadlocks: int | None = None
    reduced_states: int | None = None
    seconds: float | None = None
    peak_memory_bytes: int | None = None
    engine: str | None = None
    complete: bool = False
    error: str = ""

    @classmethod
    def of(cls, found: object) -> Figures | None:
        """Return the figures that decoded JSON holds; None if the file has no such figures."""
        types = _types_of_figures()
        if not isinstance(found, dict) or not found.keys() <= types.keys():
            return None
        fit = (
            isinstance(value, types[name]) and (types[name] is bool or not isinstance(value, bool))
            for name, value in found.items()
        )
        return cls(**found) if all(fit) else None


@cache
def _types_of_figures() -> dict[str, Any]:
    """Return the type of each figure; a journal may have a million lines of them."""
    return get_type_hints(Figures)


_COUNTED = ("places", "transitions", "states", "arcs", "deadlocks", "reduced_states", "engine", "complete")
"""Figures with the same names in a `StateSpace`."""


def count(job: Job) -> Figures:
    """Count the state space of a point in this process."""
    from dineros.analysis.nets.memory import OWN_MEMORY, watched_memory

    budget = Budget(job.memory or DEFAULT_MEMORY)
    with watched_memory(budget.memory + OWN_MEMORY):
        return _count(job, budget)


def _count(job: Job, budget: Budget) -> Figures:
    from dineros.analysis.model.subject import subject_of
    from dineros.analysis.nets.memory import peak_memory
    from dineros.analysis.questions.reduced_space import reduced_state_space
    from dineros.analysis.questions.state_space import state_space

    point = job.point
    net = subject_of(
        model_of(point, job.model),
        point.signals or "none",  # type: ignore[arg-type]
        point.overflow or "weighted",  # type: ignore[arg-type]
    ).net
    began = time.perf_counter()
    explore = reduced_state_space if point.reduced else state_space
    space = explore(net, job.engine, budget)  # type: ignore[arg-type]
    seconds, peak = round(time.perf_counter() - began, 6), peak_memory()
    counted = {name: getattr(space, name) for name in _COUNTED}
    return Figures(**counted, seconds=seconds, peak_memory_bytes=peak, error=space.reason)


@cache
def _load_engine(engine: str) -> None:
    """Load or compile an engine, so that no point needs the time for it."""
    from dineros.analysis.model import subject  # noqa: F401
    from dineros.analysis.nets.compiled import CompiledNet
    from dineros.analysis.questions import reduced_space  # noqa: F401
    from dineros.analysis.questions.state_space import state_space
    from dineros.metamodel import constraints, settings  # noqa: F401
    from dineros.metamodel.files import xmi  # noqa: F401
    from dineros.transformations.flattening import flatten  # noqa: F401

    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})])
    state_space(net, engine)  # type: ignore[arg-type]


def unanswered(job: Job | Part, error: str, **figures: Any) -> Figures | Outcome:
    """Return why a job has no answer, with the known figures."""
    if isinstance(job, Part):
        return Outcome("unknown", reason=error)
    return Figures(error=error, **figures)


def _answer(job: Job | Part) -> Figures | PartAnswer:
    from dineros.analysis.nets.memory import peak_memory

    try:
        return answer_part(job) if isinstance(job, Part) else count(job)
    except (MemoryError, BudgetError):
        return unanswered(job, "memory ran out", peak_memory_bytes=peak_memory())
    except DinerosError as error:
        return unanswered(job, str(error))
    except Exception as error:  # an error of an engine must not end the sweep
        return unanswered(job, f"unexpected {type(error).__name__}: {' '.join(str(error).split())}")


def _answer_in_a_fork(job: Job | Part) -> Any:
    with Apart(lambda _: _answer(job)) as apart:
        for _ in apart.messages():
            pass  # nothing arrives before the answer
        try:
            return apart.value()
        except ApartDiedError as died:
            return PointDiedError.of(-(died.signal or 0))


def serve(jobs: Connection) -> None:
    """Answer jobs until there are no more."""
    while True:
        job = jobs.recv()
        try:
            _load_engine(job.engine)
        except Exception as error:  # for example, a library is not installed
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            hint = "pip install 'dineros[analysis]'"
            jobs.send(SweepError(f"the engines cannot be loaded: {reason}", hint=hint))
            continue
        jobs.send(None)
        jobs.send(_answer_in_a_fork(job))


def main(parent: int, pipe: int) -> None:
    """Serve the process that started this one, through a pipe."""
    die_with(parent)
    with suppress(EOFError), Connection(pipe) as jobs:
        serve(jobs)
