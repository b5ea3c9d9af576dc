"""Tracing files for tests: what Babeltrace 2 writes of a trace of ros2_tracing, event by event."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

MILLISECOND = 1_000_000
MAIN = 1
"""The process, and its first thread."""


class Trace:
    """The text of a trace that grows.

    Addresses are numbers: of what is added, and of what belongs to it, each in its process.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._time = 1_700_000_000_000_000_000
        self._start = self._time
        self._next = 0x5000

    def at(self, time: int) -> None:
        """Go on so many nanoseconds after the beginning."""
        self._time = self._start + time

    def event(
        self,
        name: str,
        fields: str = "",
        *,
        process: int = MAIN,
        thread: int | None = None,
        host: str = "robot",
    ) -> None:
        """Add an event a microsecond later."""
        self._time += 1000
        seconds, part = divmod(self._time, 1_000_000_000)
        where = f'{{ vpid = {process}, vtid = {thread or process}, procname = "p" }}'
        body = f"{{ {fields} }}" if fields else "{ }"
        self.lines.append(f"[{seconds}.{part:09}] {host} {name}: {{ cpu_id = 0 }}, {where}, {body}\n")

    def node(self, name: str, process: int = MAIN) -> int:
        """Add a node of a full name; return its handle."""
        handle = self._new()
        namespace, _, short = name.rpartition("/")
        fields = f'node_handle = {handle:#x}, rmw_handle = 0x1, node_name = "{short}"'
        self.event("ros2:rcl_node_init", f'{fields}, namespace = "{namespace or "/"}"', process=process)
        return handle

    def publisher(self, node: int, topic: str, process: int = MAIN) -> int:
        """Add a publisher; return its handle."""
        handle = self._new()
        fields = f"publisher_handle = {handle:#x}, node_handle = {node:#x}, rmw_publisher_handle = 0x1"
        fields += f', topic_name = "{topic}", queue_depth = 10'
        self.event("ros2:rcl_publisher_init", fields, process=process)
        return handle

    def subscription(self, node: int, topic: str, process: int = MAIN) -> int:
        """Add a subscription; return its callback."""
        handle, owner, callback = self._new(), self._new(), self._new()
        fields = f"subscription_handle = {handle:#x}, node_handle = {node:#x}"
        fields += f', rmw_subscription_handle = 0x1, topic_name = "{topic}", queue_depth = 10'
        self.event("ros2:rcl_subscription_init", fields, process=process)
        fields = f"subscription_handle = {handle:#x}, subscription = {owner:#x}"
        self.event("ros2:rclcpp_subscription_init", fields, process=process)
        fields = f"subscription = {owner:#x}, callback = {callback:#x}"
        self.event("ros2:rclcpp_subscription_callback_added", fields, process=process)
        return callback

    def service(self, node: int, name: str, process: int = MAIN) -> int:
        """Add a service; return its callback."""
        handle, callback = self._new(), self._new()
        fields = f"service_handle = {handle:#x}, node_handle = {node:#x}, rmw_service_handle = 0x1"
        self.event("ros2:rcl_service_init", f'{fields}, service_name = "{name}"', process=process)
        fields = f"service_handle = {handle:#x}, callback = {callback:#x}"
        self.event("ros2:rclcpp_service_callback_added", fields, process=process)
        return callback

    def timer(self, node: int, period: int, symbol: str = "tick()", process: int = MAIN) -> int:
        """Add a timer of a period in nanoseconds; return its callback."""
        handle, callback = self._new(), self._new()
        self.event("ros2:rcl_timer_init", f"timer_handle = {handle:#x}, period = {period}", process=process)
        fields = f"timer_handle = {handle:#x}, callback = {callback:#x}"
        self.event("ros2:rclcpp_timer_callback_added", fields, process=process)
        fields = f'callback = {callback:#x}, symbol = "{symbol}"'
        self.event("ros2:rclcpp_callback_register", fields, process=process)
        fields = f"timer_handle = {handle:#x}, node_handle = {node:#x}"
        self.event("ros2:rclcpp_timer_link_node", fields, process=process)
        return callback

    def start(self, callback: int, thread: int = MAIN, process: int = MAIN) -> None:
        """Begin a run of a callback."""
        fields = f"callback = {callback:#x}, is_intra_process = 0"
        self.event("ros2:callback_start", fields, process=process, thread=thread)

    def end(self, callback: int, thread: int = MAIN, process: int = MAIN) -> None:
        """End a run of a callback."""
        self.event("ros2:callback_end", f"callback = {callback:#x}", process=process, thread=thread)

    def executor(self, thread: int = MAIN) -> None:
        """Let the executor of a thread wait."""
        self.event("ros2:rclcpp_executor_wait_for_work", "timeout = -1", thread=thread)
        self.event("ros2:rclcpp_executor_get_next_ready", thread=thread)

    def publish(
        self,
        publisher: int,
        thread: int = MAIN,
        process: int = MAIN,
        *,
        within: bool = False,
        others: bool = True,
    ) -> None:
        """Publish a message: within the process, to others, or both."""
        fields = f"publisher_handle = {publisher:#x}, message = 0x9"
        if within:
            self.event("ros2:rclcpp_intra_publish", fields, process=process, thread=thread)
        if others:
            self.event("ros2:rclcpp_publish", "message = 0x9", process=process, thread=thread)
            self.event("ros2:rcl_publish", fields, process=process, thread=thread)

    def run(self, callback: int, publishers: Iterable[int] = (), thread: int = MAIN) -> None:
        """Let a callback run that publishes on some publishers."""
        self.start(callback, thread)
        for each in publishers:
            self.publish(each, thread)
        self.end(callback, thread)

    def write(self, path: Path) -> Path:
        """Write the text."""
        path.write_text("".join(self.lines), encoding="utf-8")
        return path

    def _new(self) -> int:
        self._next += 0x10
        return self._next


def program(folder: Path, script: str) -> Path:
    """Write a program that stands for ``babeltrace2``; return the folder to put on the PATH."""
    folder.mkdir(exist_ok=True)
    file = folder / "babeltrace2"
    file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    file.chmod(0o755)
    return folder
