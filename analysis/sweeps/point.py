"""One point of a sweep: ``python -m dineros.analysis.sweeps.point PARENT`` counts the points it reads.

A job is a line of JSON on the standard input. The process loads the engines once and forks for every job, so
that each point has a process with a peak of memory of its own, and one that is killed takes nothing with it.
It answers ``{"started": true}`` when it has all it needs, and then the figures, or ``{"died": SIGNAL}``.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
import time
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, BinaryIO, get_type_hints

from dineros.analysis.answers.budget import DEFAULT_MEMORY, Budget
from dineros.analysis.sweeps.grid import Point, model_of
from dineros.analysis.sweeps.parts import Part, answer_part
from dineros.metamodel.errors import BudgetError, DinerosError


@dataclass(frozen=True)
class Job:
    """What a worker needs to count a point.

    Attributes
    ----------
    model : str
        The model, as XMI.
    point : Point
        What to change, and how to flatten.
    engine : str
        The engine; see `dineros.analysis.questions.state_space`.
    memory : int or None
        Bytes that the engine may take; the engine's default where it is None.
    timeout : float or None
        Seconds after which it is given up.
    """

    model: str
    point: Point
    engine: str = "auto"
    memory: int | None = None
    timeout: float | None = None

    def to_json(self) -> str:
        """Return it in one line."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, line: str | bytes) -> Job:
        """Read what `to_json` wrote."""
        read = json.loads(line)
        point = read.pop("point")
        settings = tuple((feature, value) for feature, value in point.pop("settings"))
        return cls(point=Point(settings, **point), **read)


@dataclass(frozen=True)
class Figures:
    """What is known of a point.

    Attributes
    ----------
    places, transitions : int or None
        Size of the net explored.
    states, arcs, deadlocks : int or None
        Exact counts; of an incomplete exploration what was seen. Where the net was reduced these are still
        those of the net itself, but arcs are not known.
    reduced_states : int or None
        Markings of the net explored, where that is a reduced one.
    seconds : float or None
        Wall-clock time of reduction, search for an order, and exploration.
    peak_memory_bytes : int or None
        The most memory that the point's process ever had, about 200 MiB of it the compiled engines.
    engine : str or None
        The engine that answered.
    complete : bool
        Whether these are all markings.
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
        """Return the figures that decoded JSON holds; None where it holds no such figures."""
        types = get_type_hints(cls)
        if not isinstance(found, dict) or not found.keys() <= types.keys():
            return None
        fit = (
            isinstance(value, types[name]) and (types[name] is bool or not isinstance(value, bool))
            for name, value in found.items()
        )
        return cls(**found) if all(fit) else None


def read_job(line: str | bytes) -> Job | Part:
    """Read what either's `to_json` wrote."""
    return Part.from_json(line) if "task" in json.loads(line) else Job.from_json(line)


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
    reason = "memory ran out" if space.reason == "memory" else space.reason
    return Figures(
        places=space.places,
        transitions=space.transitions,
        states=space.states,
        arcs=space.arcs,
        deadlocks=space.deadlocks,
        reduced_states=space.reduced_states,
        seconds=round(time.perf_counter() - began, 6),
        peak_memory_bytes=peak_memory(),
        engine=space.engine,
        complete=space.complete,
        error=reason,
    )


@cache
def _load_engine(engine: str) -> None:
    """Load, or compile, an engine, so that no point pays for it."""
    from dineros.analysis.model import subject  # noqa: F401
    from dineros.analysis.nets.compiled import CompiledNet
    from dineros.analysis.questions import reduced_space  # noqa: F401
    from dineros.analysis.questions.state_space import state_space
    from dineros.metamodel import constraints, settings  # noqa: F401
    from dineros.metamodel.files import xmi  # noqa: F401
    from dineros.transformations.flattening import flatten  # noqa: F401

    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})])
    state_space(net, engine)  # type: ignore[arg-type]


def _answer(job: Job | Part) -> dict[str, Any]:
    from dineros.analysis.nets.memory import peak_memory

    try:
        return answer_part(job) if isinstance(job, Part) else asdict(count(job))
    except (MemoryError, BudgetError):
        return asdict(Figures(peak_memory_bytes=peak_memory(), error="memory ran out"))
    except DinerosError as error:
        return asdict(Figures(error=str(error)))
    except Exception as error:  # an engine's fault must not end the sweep
        return asdict(Figures(error=f"unexpected {type(error).__name__}: {' '.join(str(error).split())}"))


def _answer_in_a_fork(job: Job | Part) -> dict[str, Any]:
    parent = os.getpid()
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            die_with(parent)
            with os.fdopen(writing, "wb") as file:
                file.write(json.dumps(_answer(job)).encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as file:
        text = file.read()
    _, status = os.waitpid(child, 0)
    answer: dict[str, Any] = json.loads(text) if text else {"died": os.waitstatus_to_exitcode(status)}
    return answer


def die_with(parent: int) -> None:
    """Have the kernel end this process when the one that started it ends, however that happens (Linux)."""
    set_parent_death_signal = 1  # PR_SET_PDEATHSIG of prctl(2)
    ctypes.CDLL(None).prctl(set_parent_death_signal, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # it ended before
        os._exit(1)


def serve(jobs: BinaryIO, answers: BinaryIO) -> None:
    """Answer jobs until there are no more."""

    def tell(answer: dict[str, Any]) -> None:
        answers.write(json.dumps(answer).encode() + b"\n")
        answers.flush()

    for line in jobs:
        job = read_job(line)
        try:
            _load_engine(job.engine)
        except Exception as error:  # such as a library that is not installed
            tell({"failed": f"{type(error).__name__}: {' '.join(str(error).split())}"})
            continue
        tell({"started": True})
        tell(_answer_in_a_fork(job))


def main(parent: int) -> None:
    """Serve the process that started this one; what libraries print goes nowhere."""
    die_with(parent)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main(int(sys.argv[1]))
