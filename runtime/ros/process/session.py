"""A ROS node, its context and the thread that runs its callbacks, created and destroyed in order.

Each session has its own context, so that several can run in one process. Additional work can run on the
thread of the session between callbacks: a node whose net fires there can react without changing threads.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.ros_names import resource_name
from dineros.runtime.application.gate import Gate
from dineros.runtime.ros.process.calm import Misfits, calm_executor
from dineros.runtime.ros.process.clocks import hold_time_source
from dineros.runtime.ros.process.memory import remove_abandoned
from dineros.runtime.scheduling.threads import join

LOG = logging.getLogger("dineros.runtime")

Work = Callable[[], "float | None"]
"""Called between callbacks; returns the seconds until it wants to be called, None: when it is woken."""


class RosError(DinerosError):
    """ROS 2 is not available, or cannot do what a node needs."""


class Session:
    """A running ROS node.

    Parameters
    ----------
    name, namespace : str
        Name and namespace of the ROS node; arguments can remap them.
    arguments : sequence of str
        Arguments for ROS: ``["--ros-args", "-r", "__ns:=/cell", "-p", "seed:=7"]``.
    executor : {"single", "multi"}
        The executor of the node; callbacks only deliver data, so one thread is usually sufficient.
    threads : int
        Threads of a multi-threaded executor.
    domain : int, optional
        The ROS domain; by default that of the environment.
    make_node : callable, optional
        Creates the rclpy node, with the arguments of ``rclpy.node.Node``.
    ending : threading.Event, optional
        Set by code that is going to end the session, such as a signal handler, before `end` is called.
    gate : Gate, optional
        Where this node waits until the other nodes of the application are ready.

    Attributes
    ----------
    node : rclpy.node.Node
        The ROS node.

    Raises
    ------
    RosError
        rclpy is not installed, or refuses the name or the arguments.
    """

    def __init__(
        self,
        name: str,
        namespace: str = "",
        *,
        arguments: Sequence[str] = (),
        executor: str = "single",
        threads: int = 1,
        domain: int | None = None,
        make_node: Callable[..., Any] | None = None,
        ending: threading.Event | None = None,
        gate: Gate | None = None,
    ) -> None:
        rclpy = import_rclpy()
        from rclpy.executors import MultiThreadedExecutor
        from rclpy.node import Node

        self._context = rclpy.Context()
        self._thread: threading.Thread | None = None
        self._ending = ending or threading.Event()
        self._gate = gate
        self._is_ending = False
        self._is_closed = False
        self._waking = threading.Lock()
        self.failure: BaseException | None = None
        try:
            rclpy.init(args=["dineros", *arguments], context=self._context, domain_id=domain)
        except Exception as error:
            raise RosError(f"ROS 2 does not start: {_first_line(error)}") from error
        try:
            self.node: Any = (make_node or Node)(
                resource_name(name), context=self._context, namespace=namespace or None
            )
            self._executor: Any = (
                MultiThreadedExecutor(max(2, threads), context=self._context)
                if executor == "multi"
                else calm_executor(self._context)
            )
        except Exception as error:
            rclpy.shutdown(context=self._context)
            raise RosError(f"the ROS node {name!r} cannot be made: {_first_line(error)}") from error
        hold_time_source(self.node)
        self._executor.add_node(self.node)
        self._misfits = Misfits(self.node, self._executor) if executor != "multi" else None

    @property
    def is_ending(self) -> bool:
        """Whether the session ends or is going to; then do not wait for other nodes any more."""
        return self._is_ending or self._ending.is_set()

    @property
    def is_own_thread(self) -> bool:
        """Whether the caller is the thread that runs the callbacks."""
        return self._thread is threading.current_thread()

    def await_others(self, limit: float) -> None:
        """Wait at most `limit` seconds until the nodes that were started with this one are ready."""
        if self._gate is None or self._gate.wait(limit, lambda: self.is_ending) or self.is_ending:
            return
        LOG.warning("after %g s, other nodes of the application are not ready", limit)

    def start(self, work: Work | None = None) -> None:
        """Run callbacks on its own thread until `close`."""
        self._thread = threading.Thread(
            target=self._run, args=(work,), name=f"ros {self.node.get_name()}", daemon=True
        )
        self._thread.start()

    def _run(self, work: Work | None) -> None:
        from rclpy.executors import ExternalShutdownException

        spin_once, misfits = self._executor.spin_once, self._misfits
        self._executor.spinner = threading.get_ident()
        try:
            while not self._is_ending:
                timeout = work() if work is not None else None
                if misfits is not None and misfits.are_due and not self._is_ending:
                    misfits.look()
                    continue  # with callbacks that became ready meanwhile
                if not self._is_ending:
                    spin_once(timeout)
        except ExternalShutdownException:
            pass
        except BaseException as error:
            if not self._is_ending:
                # The text of a DinerosError suffices: a full disk, for example, is not a fault of the
                # program.
                trace = None if isinstance(error, DinerosError) else error
                LOG.critical("the ROS node %s ends: %s", self.node.get_name(), error, exc_info=trace)
                self.failure = error
        finally:
            self._executor.spinner = None

    def wake(self) -> None:
        """Run the work between callbacks now; from any thread. Does nothing after `close`."""
        with self._waking:  # an executor must not be woken during its shutdown
            if not self._is_closed:
                self._executor.create_task(_do_nothing)

    def end(self) -> None:
        """Let the thread end after its current callback; from any thread."""
        self._is_ending = True
        self.wake()

    def join(self, timeout: float | None = None) -> bool:
        """Wait until the thread has ended; return whether it has."""
        if not self.is_own_thread:
            join(self._thread, timeout)
        return self._thread is None or not self._thread.is_alive()

    def cut_off(self) -> None:
        """Stop waiting for the thread: only a handler still runs on it, nothing of ROS."""
        self._thread = None

    def close(self) -> None:
        """End the thread, destroy the node, shut down ROS, in this order, so that nothing is left behind.

        Files of ended processes in shared memory are removed.
        """
        if self._is_closed:
            return
        self.end()
        self.join()
        with self._waking:
            self._is_closed = True
        import rclpy

        if self._misfits is not None:
            self._misfits.close()
        self._executor.shutdown()
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)
        remove_abandoned()


def _do_nothing() -> None:
    """Make the executor return: without a callback, waking it would only make it check and wait again."""


def import_rclpy() -> Any:
    """Return rclpy.

    Raises
    ------
    RosError
        rclpy is not installed.
    """
    try:
        import rclpy
    except ImportError as error:
        raise RosError(
            f"ROS 2 is not installed: {error}",
            hint="install dineros[ros], or source the setup.bash of your installation of ROS 2",
        ) from error
    return rclpy


@contextmanager
def made_in_ros(what: str) -> Iterator[None]:
    """Convert errors of ROS in the block.

    Raises
    ------
    RosError
        ROS refuses to create something.
    """
    try:
        yield
    except Exception as error:
        raise RosError(f"{what} cannot be made in ROS: {_first_line(error)}") from error


def _first_line(error: BaseException) -> str:
    return str(error).strip().partition("\n")[0] or type(error).__name__
