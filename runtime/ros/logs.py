"""Forwards records of handlers and the engine to the logs of ROS: console, log files and ``/rosout``."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from dineros.runtime.application.logs import OwnLogs, logs_to
from dineros.runtime.ros.channels.parameters import LOG_LEVEL
from dineros.runtime.ros.process.session import LOG, RosError

LEVELS = ("debug", "info", "warn", "error", "fatal")
"""Names of ROS's levels; their numbers are those of Python."""


class RosHandler(logging.Handler):
    """Passes records on to the logger of a ROS node, each with the code position where it was written.

    Records of the engine, of the root logger and of a logger with the name of the node go to the node's own
    logger; those of a logger ``camera`` go to the child ``NODE.camera``.
    """

    def __init__(self, node: Any) -> None:
        super().__init__()
        from rclpy.impl.implementation_singleton import rclpy_implementation

        # The methods of rclpy's loggers determine their caller, which would always be this class.
        self._log = rclpy_implementation.rclpy_logging_rcutils_log
        self._logger = node.get_logger()
        # While such an object exists, /rosout publishes what is logged under its name.
        self._children: dict[str, Any] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Log a record."""
        try:
            severity = min(max(record.levelno // 10 * 10, logging.DEBUG), logging.CRITICAL)
            name = self._named(record.name).name
            texts = (self.format(record), record.funcName or "", record.pathname)
            self._log(severity, name, *map(_writable, texts), record.lineno)
        except Exception:
            self.handleError(record)

    def _named(self, name: str) -> Any:
        """Return the ROS logger of a Python logger."""
        if name in ("root", "dineros", self._logger.name) or name.startswith("dineros."):
            return self._logger
        if name not in self._children:
            below = name.removeprefix(f"{self._logger.name}.")
            self._children[name] = self._logger.get_child(_writable(below))
        return self._children[name]

    def close(self) -> None:
        """Release the child loggers."""
        self._children.clear()
        super().close()


@contextmanager
def ros_logs(node: Any, level: str, arguments: Sequence[str] = (), package: str = "") -> Iterator[None]:
    """Forward all records of Python's `logging` to a ROS node's logs, while the block lasts.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    level : str
        Minimum level to log if the arguments of ROS do not set it; the parameter `log_level` changes it while
        the node runs.
    arguments : sequence of str
        The arguments of ROS; ``--log-level NODE.camera:=debug`` sets the level of the logger ``camera``.
    package : str
        Package of the handlers; it does not count as a library even if it is installed.

    Raises
    ------
    RosError
        The level is unknown.
    """
    from rclpy.logging import get_logger_effective_level, get_logging_severity_from_string

    if level not in LEVELS:
        raise RosError(f"there is no log level {level!r}", hint=f"take one of {', '.join(LEVELS)}")
    logger, told = node.get_logger(), _told_levels(arguments)
    if not any(not name or f"{logger.name}.".startswith(f"{name}.") for name in told):
        logger.set_level(get_logging_severity_from_string(level.upper()))
    # Python's loggers decide first whether a record is created.
    for name in told:
        if name.startswith(f"{logger.name}."):
            for each in (name, name.removeprefix(f"{logger.name}.")):
                logging.getLogger(each).setLevel(int(get_logger_effective_level(name)))
    handler = RosHandler(node)
    handler.addFilter(OwnLogs(package))
    with logs_to(handler, int(logger.get_effective_level())):
        leave = _obey_parameter(node, logger)
        try:
            yield
        finally:
            leave()


def _obey_parameter(node: Any, logger: Any) -> Callable[[], None]:
    """Apply the parameter `log_level` when it is set; return a function that ends this."""
    from rcl_interfaces.msg import SetParametersResult
    from rclpy.logging import get_logging_severity_from_string

    def judge(parameters: Any) -> Any:
        wrong = [
            each.value for each in parameters if each.name == LOG_LEVEL.name and each.value not in LEVELS
        ]
        reason = f"there is no log level {wrong[0]!r}: take one of {', '.join(LEVELS)}" if wrong else ""
        return SetParametersResult(successful=not wrong, reason=reason)

    def obey(parameters: Any) -> None:
        for each in parameters:
            if each.name == LOG_LEVEL.name:
                logger.set_level(get_logging_severity_from_string(each.value.upper()))
                logging.getLogger().setLevel(int(logger.get_effective_level()))
                LOG.info("logs from %s on", each.value)

    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(obey)

    def leave() -> None:
        node.remove_on_set_parameters_callback(judge)
        node.remove_post_set_parameters_callback(obey)

    return leave


def _told_levels(arguments: Sequence[str]) -> list[str]:
    """Return the loggers whose levels the ROS arguments set; an empty name: the default level."""
    found, words, is_ros = [], iter(arguments), False
    for word in words:
        if word in ("--ros-args", "--"):
            is_ros = word == "--ros-args"
        elif is_ros and word == "--log-level":
            found.append(next(words, "").rpartition(":=")[0])
    return found


def _writable(text: str) -> str:
    """Return a text in which characters that C or UTF-8 cannot represent are escaped."""
    return text.encode("utf-8", "backslashreplace").decode().replace("\0", "\\x00")
