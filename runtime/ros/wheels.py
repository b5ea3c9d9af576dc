"""The wheels of ROS 2 Jazzy, as pip installs them: made ready for building interface packages with colcon.

ROS 2's own installation brings a ``setup.bash``; the wheels bring none, and their CMake files name the Python
headers of the machine that built them, which CMake refuses. ``python -m dineros.runtime.ros.wheels`` puts
those of this Python in, writes the set-up scripts, and prints the path of the one that shells source.
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
"""The script for every shell; those of `SETUPS` hold the same."""
SETUPS = tuple(f"{kind}.{shell}" for kind in ("setup", "local_setup") for shell in ("sh", "bash", "zsh"))
"""The scripts' names as ROS 2 has them: colcon looks for ``local_setup`` wherever AMENT_PREFIX_PATH leads."""

_FOREIGN_NUMPY = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/\w+/include")
_FOREIGN_PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")

# POSIX shell, so that sh, bash and zsh read the same; sourced twice, it adds nothing twice.
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
    """Return the folder that holds the wheels of ROS 2; None where ROS 2 came in another way."""
    prefix = Path(sys.prefix)
    return prefix if (prefix / "share/ament_index").is_dir() else None


def mend_paths(prefix: Path) -> list[Path]:
    """Put this Python's header folders into the CMake files of the wheels below a folder.

    Parameters
    ----------
    prefix
        Folder with ``share/*/cmake/*.cmake``.

    Returns
    -------
    list of Path
        The files that changed; none when all was well.
    """
    changed = []
    for file in sorted(prefix.glob("share/*/cmake/*.cmake")):
        text = file.read_text(encoding="utf-8")
        if "/opt/python/" not in text:
            continue
        mended = _FOREIGN_NUMPY.sub(lambda _: _numpy_headers(), text)
        mended = _FOREIGN_PYTHON.sub(lambda _: sysconfig.get_path("include"), mended)
        if mended != text:
            write_atomically(file, mended.encode())
            changed.append(file)
    return changed


def _numpy_headers() -> str:
    import numpy

    return str(numpy.get_include())


def setup_script(prefix: Path) -> str:
    """Return the script that a shell sources to build and run with the wheels below a folder.

    It sets what ROS 2's own ``setup.bash`` does, and, in a virtual environment, the variable by which CMake
    finds its Python and no newer one of the machine (CMake manual, FindPython3).
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
    """Write the set-up scripts where they are not there yet, and return the one for every shell.

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
    """Make the wheels of the Python that runs this ready; return the exit status."""
    prefix = prefix_of_wheels()
    if prefix is None:
        return 0
    try:
        mend_paths(prefix)
        print(write_setups(prefix))
    except DinerosError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
