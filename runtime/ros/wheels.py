"""Prepares the wheels of ROS 2 Jazzy, as installed by pip, for building interface packages with colcon.

A regular installation of ROS 2 has a ``setup.bash``. The wheels have none, and their CMake files contain the
paths of Python headers on the build machine, which CMake refuses. ``python -m dineros.runtime.ros.wheels``
inserts the paths of this Python, writes the set-up scripts, and prints the path of the script to source.
"""

from __future__ import annotations

import re
import shlex
import sys
import sysconfig
from pathlib import Path

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically

SETUP = "setup.sh"
"""The script for every shell; the scripts in `SETUPS` have the same content."""
SETUPS = tuple(f"{kind}.{shell}" for kind in ("setup", "local_setup") for shell in ("sh", "bash", "zsh"))
"""Names of the scripts in ROS 2: colcon searches ``local_setup`` in the folders of AMENT_PREFIX_PATH."""

_FOREIGN_NUMPY = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/\w+/include")
_FOREIGN_PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")

# POSIX shell, so that sh, bash and zsh can read it; sourcing it twice adds nothing twice.
_SCRIPT = """\
# Written by: python -m dineros.runtime.ros.wheels
# Source this before colcon: the ROS 2 that pip installed into this folder.
_dineros_prepend() {{
  eval "_dineros_known=\\${{$1-}}"
  case ":$_dineros_known:" in
    *":$2:"*) ;;
    *) export "$1=$2${{_dineros_known:+:$_dineros_known}}" ;;
  esac
}}
{lines}
unset _dineros_known
unset -f _dineros_prepend
"""


def prefix_of_wheels() -> Path | None:
    """Return the folder of the wheels of ROS 2; None: ROS 2 was installed in another way."""
    prefix = Path(sys.prefix)
    return prefix if (prefix / "share/ament_index").is_dir() else None


def correct_paths(prefix: Path) -> list[Path]:
    """Insert this Python's header folders into the CMake files of the wheels below a folder.

    Parameters
    ----------
    prefix
        Folder with ``share/*/cmake/*.cmake``.

    Returns
    -------
    list of Path
        The changed files; empty if all were correct.
    """
    changed = []
    for file in sorted(prefix.glob("share/*/cmake/*.cmake")):
        text = file.read_text(encoding="utf-8")
        if "/opt/python/" not in text:
            continue
        corrected = _FOREIGN_NUMPY.sub(lambda _: _numpy_headers(), text)
        corrected = _FOREIGN_PYTHON.sub(lambda _: sysconfig.get_path("include"), corrected)
        if corrected != text:
            write_atomically(file, corrected.encode())
            changed.append(file)
    return changed


def _numpy_headers() -> str:
    import numpy

    return str(numpy.get_include())


def setup_script(prefix: Path) -> str:
    """Return the set-up script for building and running with the wheels below a folder.

    It sets the same variables as ROS 2's own ``setup.bash`` and, in a virtual environment, the variable by
    which CMake finds its Python instead of a newer one of the system (CMake manual, FindPython3).
    """
    libraries = [prefix / "lib", *sorted(Path(sysconfig.get_path("purelib")).glob("ros_*.libs"))]
    lines = [f"export VIRTUAL_ENV={shlex.quote(str(prefix))}"] if (prefix / "pyvenv.cfg").is_file() else []
    lines += ["export ROS_DISTRO=jazzy", "export ROS_VERSION=2", "export ROS_PYTHON_VERSION=3"]
    for name, folders in (
        ("PATH", [prefix / "bin"]),
        ("LD_LIBRARY_PATH", libraries),
        ("AMENT_PREFIX_PATH", [prefix]),
        ("CMAKE_PREFIX_PATH", [prefix]),
    ):
        lines += [f"_dineros_prepend {name} {shlex.quote(str(folder))}" for folder in reversed(folders)]
    return _SCRIPT.format(lines="\n".join(lines))


def write_setups(prefix: Path) -> Path:
    """Write the set-up scripts that do not exist yet, and return the one for every shell.

    Raises
    ------
    DinerosError
        They cannot be written.
    """
    content = setup_script(prefix).encode()
    for name in SETUPS:
        file = prefix / name
        if not file.is_file() or file.read_bytes() != content:
            write_atomically(file, content)
    return prefix / SETUP


def main() -> int:
    """Prepare the wheels of the running Python; return the exit status."""
    prefix = prefix_of_wheels()
    if prefix is None:
        return 0
    try:
        correct_paths(prefix)
        print(write_setups(prefix))
    except DinerosError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
