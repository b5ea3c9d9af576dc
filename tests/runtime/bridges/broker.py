"""A real mosquitto for a test, and certificates for it."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

MOSQUITTO = shutil.which("mosquitto", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
PATIENCE = 30.0


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Broker:
    """A mosquitto of our own."""

    def __init__(self, folder: Path, settings: str = "allow_anonymous true\n") -> None:
        self.port = free_port()
        self.config = folder / "mosquitto.conf"
        user = "user root\n" if os.geteuid() == 0 else ""  # it would not be able to read the test's files
        self.config.write_text(f"{user}listener {self.port} 127.0.0.1\npersistence false\n{settings}")
        self.start()

    def start(self) -> None:
        assert MOSQUITTO
        self.process = subprocess.Popen(
            [MOSQUITTO, "-c", str(self.config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            try:
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                return
            except OSError:
                time.sleep(0.02)
        pytest.fail("mosquitto does not start")

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(PATIENCE)

    def publish(self, topic: str, payload: str | bytes, retain: bool = False, **options: Any) -> None:
        from paho.mqtt import publish

        publish.single(topic, payload, qos=1, retain=retain, hostname="127.0.0.1", port=self.port, **options)
