"""What a node takes until it is ready, and while it waits: processor time and memory, beside a plain one.

Each starts as a process of its own, by turns: a node of rclpy with a publisher and a service, and one of
DiNeROS without handlers. ``--python PROGRAM`` takes another Python, such as that of an environment in which
only ``dineros-runtime[ros]`` is installed, and reports the size of such an environment on the disk. A node
should be ready within 0.4 s of processor time and take less than 60 MiB of memory of its own (anonymous
pages, as in ``/proc/PID/smaps_rollup``; files that are mapped, such as libraries, are shared and are told
beside).
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks._processes import mebibytes, processor_seconds
from benchmarks.running.diagnostics import lamp
from dineros.metamodel.files import save
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment

LOOK = 0.25
"""Seconds between two looks: a node is ready where it has done nothing between them."""

PATIENCE = 60.0
"""Seconds that it has to come to rest."""

PLAIN = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger
rclpy.init()
node = Node("plain")
publisher = node.create_publisher(String, "said", 10)
service = node.create_service(Trigger, "ask", lambda request, response: response)
rclpy.spin(node)
"""


def memory(process: int) -> dict[str, float]:
    """Return the memory of a process in MiB: anonymous, its part of all that it shares, and all it uses."""
    return {name: mebibytes(process, name, "smaps_rollup") for name in ("Pss_Anon", "Pss", "Rss")}


def measure(command: list[str], environment: dict[str, str]) -> tuple[float, dict[str, float]]:
    """Start a process, wait until it does nothing any more, and end it."""
    with subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL) as process:
        try:
            last, end = -1.0, time.monotonic() + PATIENCE
            while (used := processor_seconds(process.pid)) != last or used < 0.1:
                if time.monotonic() > end:
                    raise SystemExit(f"does not come to rest: {' '.join(command)}")
                last = used
                time.sleep(LOOK)
            return used, memory(process.pid)
        finally:
            process.send_signal(signal.SIGINT)


def disk(python: str) -> float:
    """Return what the environment of a Python takes, in MiB."""
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    return sum(file.lstat().st_size for file in Path(site).rglob("*") if file.is_file()) / 2**20


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", default=sys.executable, help="the Python that runs the nodes")
    parser.add_argument("--turns", type=int, default=5)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, claimed_domain() as domain:
        save(lamp(0), Path(folder) / "lamp.rtm.xmi")
        environment = ros_environment(Path(folder), domain, "memory", os.environ)
        for name in (
            "LD_LIBRARY_PATH",
            "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
        ):  # those of the Python that runs this
            environment.pop(name, None)
        model = str(Path(folder) / "lamp.rtm.xmi")
        ours = ["-m", "dineros.runtime.ros.node_main", model, "--ros-args", "-p", "diagnostics_period:=60.0"]
        ours += ["-p", "seed:=1"]
        commands = {"rclpy": ["-c", PLAIN], "DiNeROS": ours}
        found: dict[str, list[tuple[float, dict[str, float]]]] = {name: [] for name in commands}
        for _ in range(given.turns):  # side by side: what else the machine does is much the same for both
            for name, command in commands.items():
                found[name].append(measure([given.python, *command], environment))
        for name, starts in found.items():
            times = [used for used, _ in starts]
            taken = ", ".join(f"{part} {mib:.1f} MiB" for part, mib in starts[-1][1].items())
            print(
                f"{name:8} ready after {min(times):.2f} s of processor time, median "
                f"{statistics.median(times):.2f} s; {taken}"
            )
    print(f"packages on the disk: {disk(given.python):.0f} MiB")


if __name__ == "__main__":
    main()
