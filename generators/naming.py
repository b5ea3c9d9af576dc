"""Names of what is generated: ROS packages, Python functions and classes, and the collisions between them."""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Iterable

from dineros.metamodel import sym
from dineros.metamodel.elements import label
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.ros_names import camel_case, interfaces_package, resource_name, snake_case

_PACKAGE = re.compile(r"[a-z][a-z0-9_]*[a-z0-9]")
# Python packages that every generated node imports.
_TAKEN = frozenset({"dineros", "rclpy", "launch", "launch_ros", "ament_index_python", "setuptools", "pytest"})
# Words that C++ reserves; interface packages are C++ packages, too (ISO C++ 17, table 5).
_CPP_KEYWORDS = frozenset(
    """
    alignas alignof and_eq asm auto bitand bitor bool case catch char char16_t char32_t class compl concept
    const const_cast constexpr decltype default delete do double dynamic_cast else enum explicit export extern
    false float for friend goto if inline int long mutable namespace new noexcept not_eq nullptr operator
    or_eq private protected public register reinterpret_cast requires return short signed sizeof static
    static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename
    union unsigned using virtual void volatile wchar_t while xor xor_eq
    """.split()  # noqa: SIM905  (the list has 92 lines)
)


class NamingError(DinerosError):
    """A name of the model cannot be used in a ROS workspace, or two of them become the same one."""


def bringup_package(model: str) -> str:
    """Return the name of the package that starts a model's nodes, by the id of the model.

    Examples
    --------
    >>> bringup_package("sorting")
    'sorting_bringup'
    """
    return f"{snake_case(model)}_bringup"


def node_packages(model: sym.SystemModel, node_nets: Iterable[sym.NodeNet]) -> dict[str, str]:
    """Return the name of each node net's package, by the id of the node net.

    Raises
    ------
    NamingError
        Two node nets have the same package, or a package has the name of one that is needed.
    """
    own = {interfaces_package(model.id): "the interfaces", bringup_package(model.id): "the launch files"}
    packages: dict[str, str] = {}
    for node in node_nets:
        name = node.package or snake_case(label(node))
        whose = own.get(name) or ("Python" if name in sys.stdlib_module_names | _TAKEN else None)
        if whose is None and name in packages.values():
            whose = next(repr(id) for id, package in packages.items() if package == name)
        if whose is not None:
            raise NamingError(
                f"the package {name!r} of node net {node.id!r} is that of {whose}",
                element=node.id,
                hint=f"set the package of the node net, such as {snake_case(model.id)}_{snake_case(node.id)}",
            )
        if not _PACKAGE.fullmatch(name) or keyword.iskeyword(name):
            raise NamingError(
                f"{name!r} is no name for the package of node net {node.id!r}",
                element=node.id,
                hint="set the package of the node net: two or more small letters, digits and _",
            )
        packages[node.id] = name
    return packages


def node_name(node: sym.NodeNet) -> str:
    """Return the name of the ROS node: that of the node net, mended where ROS does not accept it."""
    return resource_name(label(node))


def functions(ids: Iterable[str]) -> dict[str, str]:
    """Return a Python function's name for each id, all different."""
    return _distinct(ids, snake_case)


def classes(ids: Iterable[str]) -> dict[str, str]:
    """Return a Python class's name for each id, all different."""
    return _distinct(ids, camel_case)


def _distinct(ids: Iterable[str], case: object) -> dict[str, str]:
    assert callable(case)
    names: dict[str, str] = {}
    for id in ids:
        stem = str(case(id))
        name = f"{stem}_" if keyword.iskeyword(stem) else stem
        number = 1
        while name in names.values():
            number += 1
            name = f"{stem}_{number}"
        names[id] = name
    return names


def message_fields(token_type: sym.TokenType | None) -> dict[str, str]:
    """Return the name of each token field in messages.

    Raises
    ------
    NamingError
        Two fields get the same name, or one that ROS interfaces cannot have.
    """
    names: dict[str, str] = {}
    for field in token_type.fields if token_type else ():
        name = snake_case(field.name)
        problem = None
        if name == "message_id":
            problem = "which carries the id of the message"
        elif name in names.values():
            problem = f"as does {next(repr(known) for known, same in names.items() if same == name)}"
        elif name in _CPP_KEYWORDS or keyword.iskeyword(name):
            problem = "a keyword of C++ or Python"
        if problem:
            raise NamingError(
                f"token field {field.name!r} becomes the message field {name!r}, {problem}",
                element=token_type.id if token_type else None,
                hint="rename the field",
            )
        names[field.name] = name
    return names
