"""Run several ROS programs, each in a process and a namespace of its own, until standard input is closed.

Usage: ``python forking.py FOLDER LOGS PROGRAM...``. ROS is imported once, by the process that the others are
forked from. What a program prints goes to ``LOGS/PROGRAM.log``. Programs that block hear no signal, so all
are killed.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
from importlib import import_module
from pathlib import Path


def start(program: Path, log: Path) -> int:
    """Fork a process that runs a program as if it were started by its name; return the process."""
    process = os.fork()
    if process:
        return process
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    for stream in (1, 2):
        os.dup2(file, stream)
    sys.argv = [str(program), "--ros-args", "-r", f"__ns:=/{program.stem}"]
    sys.path.insert(0, str(program.parent))
    runpy.run_path(str(program), run_name="__main__")
    os._exit(0)


def main() -> None:
    """Start the programs and wait for the end of input."""
    for module in ("rclpy.executors", "rclpy.node", "std_msgs.msg", "std_srvs.srv"):
        import_module(module)

    folder, logs, names = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
    processes = [start(folder / f"{name}.py", logs / f"{name}.log") for name in names]
    sys.stdin.read()
    for process in processes:
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)


if __name__ == "__main__":
    main()
