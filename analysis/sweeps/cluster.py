"""Workers of a Dask cluster (dask.distributed), for ``--scheduler``."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar

from dineros.analysis.sweeps.grid import SweepError
from dineros.analysis.sweeps.parts import Part
from dineros.analysis.sweeps.point import Job, unanswered
from dineros.analysis.sweeps.workers import PointProcesses

if TYPE_CHECKING:
    from distributed import Client

J = TypeVar("J", bound=Job | Part)

PATIENCE = 60
"""Seconds to wait for the scheduler, and for the first worker."""


def answer_on_worker(job: Job | Part) -> Any:
    """Answer a job; runs on a worker of the cluster, which starts child processes for this."""
    return _processes().answer(job)


def end_on_worker(work: str) -> None:
    """End the parts of a work that are no longer needed; runs on a worker."""
    _processes().end_work(work)


@cache
def _processes() -> PointProcesses:
    return PointProcesses()


def cluster_answers(jobs: Iterable[J], address: str) -> Generator[tuple[J, Any], None, None]:
    """Answer jobs on a Dask cluster; yield each with its answer, or with an error, when it is done.

    Closing the generator ends unfinished jobs, if these are parts of a work.

    If a worker dies, the scheduler gives its jobs to others; a job during which several workers die is given
    up (``distributed.scheduler.allowed-failures``).

    `address`: address of the scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    SweepError
        distributed is not installed, the cluster is or becomes unavailable, or its workers cannot count.
    """
    try:
        from distributed import KilledWorker, as_completed
    except ImportError:
        raise SweepError(
            "a scheduler needs dask.distributed", hint="pip install 'dineros[cluster]'"
        ) from None

    waiting = iter(jobs)
    with _connected(address) as client:
        running: dict[Any, J] = {}
        completed = as_completed(loop=client.loop)

        def submit_some() -> None:
            # Enough jobs to keep the workers busy, but no more: each point contains its model.
            most = 2 * sum(client.nthreads().values()) + 2
            while len(running) < most and (job := next(waiting, None)) is not None:
                future = client.submit(answer_on_worker, job, pure=False)
                running[future.key] = job
                completed.add(future)

        try:
            submit_some()
            for future in completed:
                if future.status not in ("finished", "error"):
                    raise SweepError(
                        f"the connection to the scheduler at {address} was lost",
                        hint="run the same command again to continue",
                    )
                job = running.pop(future.key)
                error = future.exception()
                if error is None:
                    yield job, future.result()
                elif isinstance(error, KilledWorker):
                    yield job, unanswered(job, f"its workers died: {' '.join(str(error).split())}")
                elif isinstance(error, SweepError):
                    raise SweepError(f"a worker of {address}: {error.message}", hint=error.hint)
                else:
                    reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
                    raise SweepError(
                        f"a worker of {address} cannot run the analysis: {reason}",
                        hint="install the same dineros[analysis] on all workers",
                    )
                submit_some()
        finally:
            works = {job.work for job in running.values() if isinstance(job, Part)}
            with suppress(Exception):  # all answers are there; an unavailable worker ends by itself
                client.cancel(list(completed.futures))
                for work in works:
                    client.run(end_on_worker, work)


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    from distributed import Client

    options: dict[str, Any] = {"timeout": PATIENCE, "set_as_default": False}
    try:
        client = Client(address, **options)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SweepError(
            f"no scheduler at {address!r}: {reason}", hint="for example tcp://10.0.0.1:8786"
        ) from None
    try:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise SweepError(
                f"no worker connected to the scheduler at {address} within {PATIENCE:g} s",
                hint=f"dask worker {address}",
            ) from None
        yield client
    finally:
        client.close()
