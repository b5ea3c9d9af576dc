"""Loads the Python classes of ROS interfaces by name."""

from __future__ import annotations

import importlib
from typing import Any

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.metamodel.token_types.installed import COMMON, how_to_install


class InterfaceError(DinerosError):
    """A ROS interface is missing, or does not fit the model."""


def load_interface(name: str) -> Any:
    """Return the class of a ROS interface.

    Parameters
    ----------
    name : str
        For example ``std_msgs/msg/String``.

    Raises
    ------
    InterfaceError
        The package is not installed, has no such interface, or cannot be loaded.
    """
    package, kind, type_name = _parts(name)
    try:
        importlib.import_module(package)
        module = importlib.import_module(f"{package}.{kind}")
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != package:
            raise InterfaceError(f"{name} cannot be loaded: {error}") from error
        raise InterfaceError(
            f"the ROS interface {name} is not installed",
            hint=how_to_install(package)
            if package in COMMON
            else "build the workspace and source its install/local_setup.bash",
        ) from None
    except (ImportError, SyntaxError) as error:
        raise InterfaceError(f"{name} cannot be loaded: {error}") from error
    found = getattr(module, type_name, None)
    if found is None:
        known = [each for each in dir(module) if each[:1].isupper()]
        raise InterfaceError(
            f"the package {package} has no {kind} {type_name}", hint=near_matches(type_name, known)
        )
    try:
        # Loads the C library, which fails if the dynamic linker does not know its folder.
        found.__class__.__import_type_support__()
    except Exception as error:
        raise InterfaceError(
            f"the library of {name} cannot be loaded: {error}",
            hint="source the install/local_setup.bash of its workspace before starting",
        ) from error
    return found


def _parts(name: str) -> tuple[str, str, str]:
    package, _, rest = name.partition("/")
    kind, _, type_name = rest.partition("/")
    if not package.isidentifier() or kind not in ("msg", "srv", "action") or not type_name.isidentifier():
        raise InterfaceError(
            f"{name!r} is not the name of a ROS interface",
            hint="write it like std_msgs/msg/String, std_srvs/srv/SetBool or nav2_msgs/action/Spin",
        )
    return package, kind, type_name
