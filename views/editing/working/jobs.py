"""Starts, watches and stops the jobs of pages in other processes; no process outlives the editor."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shlex
import signal
import tempfile
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dineros.analysis.answers.processes import ProcessTree
from dineros.metamodel.editing import CommandError, Document
from dineros.metamodel.elements import elements
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.records.files import SUFFIX, node_traces
from dineros.views.editing.working.node_logs import NodeLogs
from dineros.views.editing.working.orders import TRACES, WITNESS, Order, order_of

MOST_RUNNING = 3
"""Limit of the running jobs."""

MOST_KEPT = 20
"""Limit of the jobs that pages see; older ones are discarded."""

MOST_LINES, FIRST_LINES, LONGEST_LINE = 300, 20, 2_000
"""Limits of the log lines of a job that pages get: first ones, with the address of a run, and last ones."""

LONGEST_ANSWER = 32 << 20
"""Limit of the bytes of a job's answer."""

LARGEST_TRACES = 4 << 20
"""Limit of the bytes of traces in a game: their replay blocks other requests."""

PATIENCE, PATIENCE_WITH_RUNS = 5.0, 15.0
"""Seconds that a job has to end after a request to stop; a run gives its nodes most of them."""

LOOK = 0.5
"""Seconds between two reads of the output of nodes."""

SAY_SECONDS = "DINEROS_SAY_SECONDS"
"""Environment variable: the interval of a command's progress reports."""


@dataclass
class Job:
    """A job of another process.

    Attributes
    ----------
    number : int
        Its number for pages.
    order : Order
        What.
    revision : int
        The state of the model to which it belongs.
    folder : Path
        The folder of its files.
    model : str
        The name of the model's file.
    state : {"running", "ending", "done", "failed", "cancelled"}
        ``ending``: it was asked to end; ``done``: it has answered, if only that it does not know.
    at : str
        Where it is.
    log : list of str
        What it printed besides its answer.
    result : dict
        Its answer.
    """

    number: int
    order: Order
    revision: int
    epoch: str
    folder: Path
    model: str
    state: str = "running"
    at: str = ""
    log: list[str] = field(default_factory=list)
    result: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return it for pages."""
        return {
            "job": self.number,
            "kind": self.order.kind,
            "words": self.order.words,
            "line": shlex.join(
                ["dineros", self.order.kind, self.order.workspace or self.model, *self.order.arguments]
            ),
            "epoch": self.epoch,
            "revision": self.revision,
            "state": self.state,
            "at": self.at,
            "log": self.log,
            "result": self.result,
        }


class Jobs:
    """All jobs of one editor.

    Parameters
    ----------
    document : Document
        The model.
    program : sequence of str or None
        What begins every command line: ``dineros`` itself; None: nothing can be done here.
    tell : callable
        Gets the message for all pages when something about a job has changed.
    """

    def __init__(
        self, document: Document, program: Sequence[str] | None, tell: Callable[[dict[str, Any]], None]
    ) -> None:
        self._document, self._program, self._tell = document, program, tell
        self._jobs: dict[int, Job] = {}
        self._tasks: dict[int, asyncio.Task[None]] = {}
        self._processes: dict[int, Process] = {}
        self._number = 0
        self._place = contextlib.ExitStack()
        self._folder: Path | None = None

    def known(self) -> list[dict[str, Any]]:
        """Return all jobs, the oldest first."""
        return [job.to_dict() for job in self._jobs.values()]

    def start(self, said: dict[str, Any]) -> int:
        """Start a job for a page; return its number.

        An equal running job is not started again; a new check stops one of an earlier model.

        Raises
        ------
        DinerosError
            It is not possible, or too many jobs are running.
        """
        document = self._document
        if self._program is None:
            raise CommandError("this editor was started without a program for commands")
        order = order_of(said, document.path.absolute().parent)
        if order.needs_file and not document.is_saved:
            raise CommandError("the model is not saved", hint="save it first")
        state = document.epoch, document.revision
        for job in self._running():
            if job.order == order and (job.epoch, job.revision) == state:
                return job.number
            if order.kind == job.order.kind == "check":
                self.cancel(job.number)
        if len(self._running()) > MOST_RUNNING:
            raise CommandError("too many jobs are running already", hint="cancel something")
        self._number += 1
        folder = self._new_folder(self._number)
        model = document.path.absolute()
        if not document.is_saved:  # it is asked about as it is drawn
            model = folder / document.path.name
            write_atomically(model, document.content().data)
        job = Job(self._number, order, state[1], state[0], folder, document.path.name)
        self._jobs[job.number] = job
        self._forget()
        line = [*self._program, *order.line(model, folder)]
        self._tasks[job.number] = asyncio.get_running_loop().create_task(self._do(job, line))
        return job.number

    def cancel(self, number: int) -> None:
        """Request a job to end, as Ctrl-C does; it is killed if it does not.

        Raises
        ------
        CommandError
            The job does not exist.
        """
        job = self._job(number)
        if job.state != "running":
            return
        job.state = "ending"
        process = self._processes.get(number)
        if process is not None and process.returncode is None:
            process.send_signal(signal.SIGINT)
            patience = PATIENCE_WITH_RUNS if job.order.kind == "run" else PATIENCE
            asyncio.get_running_loop().call_later(patience, _end, process)
        self._tell(job.to_dict())

    def traces(self, number: int, witness: int | None) -> dict[str, str]:
        """Return the texts of the traces of a job: of a finding, or of the nodes of its run.

        Raises
        ------
        CommandError
            The job does not exist, or has produced none.
        """
        job = self._job(number)
        if witness is None:
            files = _traces_of(job)
        else:
            first = job.folder / WITNESS
            path = first if witness == 1 else first.with_name(f"{first.stem}.{witness}{first.suffix}")
            files = {path.name: [path]} if path.is_file() else {}
        sizes = {path: path.stat().st_size for paths in files.values() for path in paths}
        if sum(sizes.values()) > LARGEST_TRACES:
            raise CommandError(
                "these traces are too long to be played in the editor", hint="use dineros trace to show them"
            )
        texts = {
            name: b"".join(read_bytes(path, limit=LARGEST_TRACES) for path in paths if sizes[path])
            for name, paths in files.items()
        }
        found = {name: text.decode("utf-8", "replace") for name, text in texts.items() if text}
        if not found:
            raise CommandError("the job has produced no trace to play")
        return found

    async def close(self) -> None:
        """Stop all jobs and remove their files."""
        for process in self._processes.values():
            _end(process)
        for task in self._tasks.values():
            task.cancel()
        await asyncio.gather(*self._tasks.values(), return_exceptions=True)
        self._place.close()

    def _job(self, number: int) -> Job:
        if number not in self._jobs:
            raise CommandError(f"there is no job {number}")
        return self._jobs[number]

    def _running(self) -> list[Job]:
        return [job for job in self._jobs.values() if job.number in self._tasks]

    def _new_folder(self, number: int) -> Path:
        if self._folder is None:
            self._folder = Path(
                self._place.enter_context(tempfile.TemporaryDirectory(prefix="dineros-edit-"))
            )
        folder = self._folder / str(number)
        folder.mkdir()
        return folder

    def _forget(self) -> None:
        for number in list(self._jobs)[:-MOST_KEPT]:
            if number not in self._tasks:
                del self._jobs[number]

    async def _do(self, job: Job, line: list[str]) -> None:
        """Run the job in a process; pages are always notified of its end."""
        self._tell(job.to_dict())
        try:
            await self._watch(job, line)
        except asyncio.CancelledError:
            raise
        except Exception as error:  # a mistake of ours, or no process: others continue
            job.state = "failed"
            _log(job, f"{type(error).__name__}: {error}")
        finally:
            process = self._processes.pop(job.number, None)
            if process is not None and process.returncode is None:
                _end(process)
                with contextlib.suppress(ProcessLookupError):
                    await process.wait()
            self._tasks.pop(job.number, None)
        self._tell(job.to_dict())

    async def _watch(self, job: Job, line: list[str]) -> None:
        environment = {**os.environ, SAY_SECONDS: "0.5", "PYTHONUNBUFFERED": "1"}
        process = await asyncio.create_subprocess_exec(
            *line, stdin=DEVNULL, stdout=PIPE, stderr=PIPE, env=environment, limit=LONGEST_ANSWER
        )
        self._processes[job.number] = process
        if job.state == "ending":
            process.send_signal(signal.SIGINT)
        assert process.stdout is not None and process.stderr is not None
        looking = asyncio.create_task(self._look(job))
        try:
            answer, _ = await asyncio.gather(
                self._read(job, process.stdout), self._listen(job, process.stderr)
            )
            status = await process.wait()
        finally:
            looking.cancel()
            await asyncio.gather(looking, return_exceptions=True)
        job.at = ""
        with contextlib.suppress(DinerosError):
            found = decode_json(answer, limit=LONGEST_ANSWER)
            if isinstance(found, dict):
                job.result = self._result(job, found)
        if job.state == "ending":
            job.state = "cancelled"
        else:
            job.state = "done" if job.result and status in (0, 1, 2, 3) else "failed"

    async def _read(self, job: Job, stream: asyncio.StreamReader) -> bytes:
        """Return its answer, one JSON object; earlier output belongs to the log."""
        pieces, size = list[bytes](), 0
        async for line in stream:
            if not pieces and not line.startswith(b"{"):
                _log(job, line.decode("utf-8", "replace").rstrip("\n")[:LONGEST_LINE])
                self._tell(job.to_dict())
                continue
            size += len(line)
            if size <= LONGEST_ANSWER:
                pieces.append(line)
        return b"".join(pieces)

    async def _listen(self, job: Job, stream: asyncio.StreamReader) -> None:
        """Read its output: progress, and everything else."""
        async for raw in stream:
            text = raw.decode("utf-8", "replace").rstrip("\n")[:LONGEST_LINE]
            seconds, _, at = text.partition(" s: ")
            if at and seconds.isdigit():
                job.at = at
            else:
                _log(job, text)
            self._tell(job.to_dict())

    async def _look(self, job: Job) -> None:
        """Read the output of the nodes of a run from their files; the rest at the end of the run."""
        if job.order.kind != "run":
            return
        logs = NodeLogs(job.folder / TRACES)
        try:
            while True:
                await asyncio.sleep(LOOK)
                if self._take(job, logs):
                    self._tell(job.to_dict())
        finally:
            self._take(job, logs)

    def _take(self, job: Job, logs: NodeLogs) -> bool:
        lines = logs.new_lines()
        for line in lines:
            _log(job, line[:LONGEST_LINE])
        return bool(lines)

    def _result(self, job: Job, found: dict[str, Any]) -> dict[str, Any]:
        """Return the answer for pages: elements by handle, witnesses by number."""
        if job.order.kind == "check":
            handles = {
                each.id: handle
                for each in elements(self._document.root)
                if (handle := self._document.handles.of(each)) is not None
            }
            number = 0
            for finding in found.get("findings", []):
                number += finding.get("witness") is not None
                finding["witness"] = number if finding.get("witness") is not None else None
                finding["elements"] = [handles[each] for each in finding["elements"] if each in handles]
        elif "witness" in found:
            found["witness"] = 1 if found["witness"] is not None else None
        if job.order.kind == "run":
            found["traces"] = bool(_traces_of(job))
        return found


def _log(job: Job, text: str) -> None:
    job.log.append(text)
    if len(job.log) > MOST_LINES:
        job.log[FIRST_LINES : FIRST_LINES + len(job.log) - MOST_LINES + 1] = ["…"]


def _traces_of(job: Job) -> dict[str, list[Path]]:
    """Return the files of each node's trace, without other files of a supervisor."""
    folder = job.folder / TRACES
    if not folder.is_dir():
        return {}
    return {f"{node}{SUFFIX}": paths for node, paths in node_traces(folder).items()}


def _end(process: Process) -> None:
    if process.returncode is None:
        ProcessTree(process.pid).end()
