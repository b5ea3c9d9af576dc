"""Builds a workspace with colcon, and returns the environment to run its nodes without sourcing a set-up.

Only the interface package needs a compiler: nodes are Python and run from their sources. A hash of the inputs
of a build is stored, so that nothing is built twice: another id or name of the model changes only comments.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path

from lxml import etree

from dineros.generators.workspace.comparison import WorkspaceError
from dineros.generators.workspace.manifest import Manifest, read_manifest
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.files.reading import read_bytes

STAMP = ".built-from"
LOG = "log/dineros_build.txt"
JOBS = 2
"""Maximum number of parallel compilers."""
# Elements of a package.xml that only describe the package (REP 149).
_DESCRIPTIONS = ("description", "maintainer", "author", "license", "url")


class BuildError(DinerosError):
    """The workspace cannot be built."""


def missing_tools() -> list[str]:
    """Return the missing tools for building interface packages; empty: all are available."""
    missing = [program for program in ("g++", "cmake", "make") if shutil.which(program) is None]
    if importlib.util.find_spec("colcon_core") is None and shutil.which("colcon") is None:
        missing.append("colcon")
    if importlib.util.find_spec("rosidl_parser") is None:
        missing.append("the interface generators of ROS 2 (rosidl)")
    return missing


def build_interfaces(workspace: Path) -> Path:
    """Build the interface package of a workspace, unless it was built from the same files.

    `workspace`: a generated workspace.

    Returns
    -------
    Path
        The folder in which it is installed.

    Raises
    ------
    BuildError
        A tool is missing, or the build fails; the hint names the log.
    """
    manifest = manifest_of(workspace)
    package = manifest.interfaces
    installed = workspace / "install" / package
    wanted = _fingerprint(workspace, package)
    folder, stamp = ConfinedFolder(workspace), f"install/{package}/{STAMP}"
    if folder.read(stamp) == wanted.encode():
        return installed
    for place in ("install", "build"):  # old files of renamed or removed interfaces would remain
        folder.remove_tree(f"{place}/{package}")
    colcon(workspace, ["--packages-select", package])
    remember(workspace)
    return installed


def remember(workspace: Path) -> None:
    """Record that the installed interfaces were built from the current files, for example by colcon.

    `build_interfaces` then does not build them again.
    """
    package = manifest_of(workspace).interfaces
    wanted = _fingerprint(workspace, package)
    ConfinedFolder(workspace).write(f"install/{package}/{STAMP}", wanted.encode())


def colcon(workspace: Path, arguments: Sequence[str] = ()) -> None:
    """Run ``colcon build`` in a workspace.

    Raises
    ------
    BuildError
        A tool is missing, or the build fails; the hint names the log.
    """
    missing = missing_tools()
    if missing:
        raise BuildError(
            f"cannot be built: {', '.join(missing)} missing",
            location=Location(workspace),
            hint="install dineros[ros-build], g++ and cmake, or run in process with 'dineros run --local'",
        )
    found = importlib.util.find_spec("colcon_core") is not None
    program = [sys.executable, "-P", "-m", "colcon"] if found else ["colcon"]
    log = workspace / LOG
    command = [*program, "build", *arguments]
    setup = _wheels_setup(workspace) if found else None
    if setup:  # build in the environment that developers source
        command = ["sh", "-c", '. "$0" && exec "$@"', setup, *command]
    variables = {**os.environ, "MAKEFLAGS": f"-j{JOBS}", "CMAKE_BUILD_PARALLEL_LEVEL": str(JOBS)}
    with os.fdopen(ConfinedFolder(workspace).start(LOG), "wb") as output:
        status = _run(command, workspace, variables, output.fileno())
    if status:
        raise BuildError(
            f"colcon build fails with status {status}: {_first_error(log)}",
            location=Location(workspace),
            hint=f"see {log} for the complete output",
        )


def environment(workspace: Path, base: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the environment in which the nodes of a workspace run from their sources.

    Parameters
    ----------
    workspace : Path
        A generated workspace, its interfaces built.
    base : mapping of str to str, optional
        The environment to extend; by default that of this process.
    """
    manifest = manifest_of(workspace)
    workspace = workspace.resolve()
    extended = dict(os.environ if base is None else base)
    installed = workspace / "install" / manifest.interfaces
    sources = [workspace / "src" / node.package for node in manifest.nodes]
    _prepend(
        extended, "PYTHONPATH", [*sources, workspace / "src" / manifest.bringup, _site_packages(installed)]
    )
    _prepend(extended, "LD_LIBRARY_PATH", [installed / "lib"])
    _prepend(extended, "AMENT_PREFIX_PATH", [installed, *_wheels()])
    return extended


def manifest_of(workspace: Path) -> Manifest:
    """Return the manifest of a workspace.

    Raises
    ------
    WorkspaceError
        The folder is not a generated workspace.
    """
    manifest = read_manifest(workspace)
    if manifest is None:
        hint = "'dineros generate MODEL -o WORKSPACE' makes one"
        raise WorkspaceError("is not a generated workspace", location=Location(workspace), hint=hint)
    return manifest


def _fingerprint(workspace: Path, package: str) -> str:
    """Return a hash of all inputs of a package's build, without comments and descriptions."""
    digest = hashlib.sha256(f"{sys.version} {sysconfig.get_platform()} {sys.prefix}".encode())
    folder, root = ConfinedFolder(workspace), f"src/{package}"
    for path in folder.files(root):
        digest.update(f"\0{path.removeprefix(f'{root}/')}\0".encode())
        digest.update(_meaning(Path(path).name, folder.read(path) or b""))
    return digest.hexdigest()


def _meaning(name: str, content: bytes) -> bytes:
    """Return the part of an interface package's file that affects the build."""
    if name == "package.xml":
        with contextlib.suppress(etree.XMLSyntaxError):
            root = etree.fromstring(content, etree.XMLParser(resolve_entities=False, remove_comments=True))
            etree.strip_elements(root, *_DESCRIPTIONS, with_tail=False)
            return b"\n".join(line.strip() for line in etree.tostring(root).splitlines() if line.strip())
    elif name == "CMakeLists.txt" or name.endswith((".msg", ".srv", ".action")):
        lines = (line.strip() for line in content.splitlines())
        return b"\n".join(line for line in lines if line and not line.startswith(b"#"))
    return content


def _wheels_setup(workspace: Path) -> str | None:
    """Prepare the wheels of ROS 2; return their set-up script, None: ROS 2 was installed in another way."""
    command = [sys.executable, "-P", "-m", "dineros.runtime.ros.wheels"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BuildError(
            f"cannot be built: {done.stderr.strip()}",
            location=Location(workspace),
            hint=f"a user who may write there can run: {shlex.join(command)}",
        )
    return done.stdout.strip() or None


def _wheels() -> list[Path]:
    """Return the folders of the wheels of ROS 2; empty: ROS 2 was installed in another way."""
    prefix = Path(sys.prefix)
    return [prefix] if (prefix / "share/ament_index").is_dir() else []


def _site_packages(installed: Path) -> Path:
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    return installed / "lib" / version / "site-packages"


def _prepend(environment: dict[str, str], name: str, folders: Sequence[Path]) -> None:
    known = [part for part in environment.get(name, "").split(os.pathsep) if part]
    new = [str(folder) for folder in folders if str(folder) not in known]
    if new or known:
        environment[name] = os.pathsep.join([*new, *known])


def _run(command: Sequence[str], folder: Path, environment: Mapping[str, str], output: int) -> int:
    """Run a program; an interrupt ends it with all processes that it started."""
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        return process.wait()
    except BaseException:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        raise


def _first_error(log: Path) -> str:
    """Return the most informative line of a build's log."""
    lines = read_bytes(log, follow_links=False).decode("utf-8", "replace").splitlines()
    for line in lines:
        if "error" in line.lower() and "stderr" not in line.lower():
            return line.strip()[:200]
    return lines[-1].strip()[:200] if lines else "it said nothing"
