"""What the engine logs, among the logs of ROS."""

from __future__ import annotations

import logging
from typing import Any

from dineros.runtime.ros.session import RosError

LEVELS = {
    "debug": logging.DEBUG,
    "info": logging.INFO,
    "warn": logging.WARNING,
    "error": logging.ERROR,
    "fatal": logging.CRITICAL,
}


class _RosHandler(logging.Handler):
    """Passes records on to the logger of a ROS node: the console, ROS's log files, ``/rosout``."""

    def __init__(self, logger: Any) -> None:
        super().__init__()
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        """Log a record."""
        text = self.format(record)
        if record.levelno >= logging.CRITICAL:
            self._logger.fatal(text)
        elif record.levelno >= logging.ERROR:
            self._logger.error(text)
        elif record.levelno >= logging.WARNING:
            self._logger.warning(text)
        elif record.levelno >= logging.INFO:
            self._logger.info(text)
        else:
            self._logger.debug(text)


def follow_logs(node: Any, level: str) -> None:
    """Let a ROS node log what the engine logs, from a level on.

    Raises
    ------
    RosError
        There is no such level.
    """
    from rclpy.impl.logging_severity import LoggingSeverity

    if level not in LEVELS:
        raise RosError(f"there is no log level {level!r}", hint=f"take one of {', '.join(LEVELS)}")
    node.get_logger().set_level(LoggingSeverity[level.upper()])
    logger = logging.getLogger("dineros")
    for handler in [known for known in logger.handlers if isinstance(known, _RosHandler)]:
        logger.removeHandler(handler)
    logger.setLevel(LEVELS[level])
    logger.addHandler(_RosHandler(node.get_logger()))
    logger.propagate = False
