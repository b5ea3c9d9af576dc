"""The wheels of ROS 2 Jazzy, as pip installs them: mending them so that interface packages can be built.

The wheels' CMake files name the Python headers of the machine that built the wheels, and CMake refuses
folders that are not there. ``python -m dineros.runtime.ros.wheels`` puts those of this Python in.
"""

from __future__ import annotations

import re
import sys
import sysconfig
from pathlib import Path

from dineros.metamodel.files.atomic import write_atomically

_FOREIGN_NUMPY = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/\w+/include")
_FOREIGN_PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")


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


def main() -> None:
    """Mend the wheels of the Python that runs this."""
    prefix = prefix_of_wheels()
    if prefix is not None:
        mend_paths(prefix)


if __name__ == "__main__":
    main()
