"""Listening to the nodes of a running application."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dineros.runtime.ros.overview import Overview
    from dineros.runtime.ros.process.environment import Reach


@contextmanager
def listening(domain: int, reach: Reach) -> Iterator[Overview]:
    """Hear the nodes of a domain as long as the block lasts.

    Raises
    ------
    RosError
        ROS is not there.
    """
    from dineros.runtime.ros.overview import Listener, Overview
    from dineros.runtime.ros.process.environment import ros_environment

    overview = Overview()
    with TemporaryDirectory(prefix="dineros-top-") as folder:
        os.environ.update(ros_environment(Path(folder), domain, reach))
        with Listener(overview):
            yield overview
