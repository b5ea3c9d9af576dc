"""Finds the programs of a folder: entry points of packages, and scripts."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from dineros.sources.folders import SourceFolder
from dineros.sources.language.modules import Module, Modules
from dineros.sources.packages import Package


@dataclass(eq=False)
class Program:
    """A program that can be started."""

    name: str
    """Of the executable."""
    path: str
    """Its file."""
    function: str | None = None
    """Of an entry point; None: the script itself."""
    package: str = ""
    """The package to which it belongs."""

    @property
    def full(self) -> str:
        """Its name with its package."""
        return f"{self.package}/{self.name}" if self.package else self.name


def programs_of(folder: SourceFolder, packages: Sequence[Package], modules: Modules) -> list[Program]:
    """Return the programs of a folder: entry points first, then scripts."""
    found: list[Program] = []
    for package in packages:
        for executable, target in package.programs.items():
            dotted, _, function = target.partition(":")
            path = _file_of(dotted, package, folder) if function else target
            if path is not None and path in folder.scripts:
                module = modules.module(path)
                runs_alone = module is not None and _called_at_once(module) == function
                start = None if runs_alone else function or None
                found.append(Program(executable, path, start, package.name))
    covered = {(each.path, each.function) for each in found}
    for path in folder.scripts:
        name = PurePosixPath(path).name
        if (
            name in ("setup.py", "conftest.py")
            or name.endswith((".launch.py", "_launch.py"))
            or "test" in PurePosixPath(path).parts
        ):
            continue
        module = modules.module(path)
        if module is None:
            continue
        guard, owner = guard_of(module), _package_of(path, packages)
        called = only_call(guard)
        if guard is not None or _spins(module.tree.body) or _called_at_once(module) is not None:
            if (path, called) not in covered and (path, None) not in covered:
                found.append(Program(name, path, None, owner))
            continue
        if not any(each.path == path for each in found):
            found += [Program(f"{name}:{each}", path, each, owner) for each in _mains(module)]
    return found


def _mains(module: Module) -> list[str]:
    """Return the functions of a module that start rclpy, for programs with entry points in other files."""
    return [
        node.name
        for node in module.tree.body
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        and len(node.args.args) <= len(node.args.defaults)
        and _spins(node.body, is_deep=True)
    ]


def _called_at_once(module: Module) -> str | None:
    """Return the function that starts rclpy and that a module calls whenever it is imported."""
    mains = _mains(module)
    calls = [each.value for each in module.tree.body if isinstance(each, ast.Expr)]
    names = [each.func.id for each in calls if isinstance(each, ast.Call) and isinstance(each.func, ast.Name)]
    return next((name for name in names if name in mains), None)


def _package_of(path: str, packages: Sequence[Package]) -> str:
    inside = [each for each in packages if each.path == "." or path.startswith(f"{each.path}/")]
    return max(inside, key=lambda each: len(each.path)).name if inside else ""


def _file_of(dotted: str, package: Package, folder: SourceFolder) -> str | None:
    base = "" if package.path == "." else f"{package.path}/"
    for start in ("", "src/"):
        inner = f"{base}{start}{dotted.replace('.', '/')}"
        for path in (f"{inner}.py", f"{inner}/__init__.py"):
            if path in folder.scripts:
                return path
    ends = f"/{dotted.replace('.', '/')}.py"
    return next((path for path in folder.scripts if path.startswith(base) and path.endswith(ends)), None)


def guard_of(module: Module) -> ast.If | None:
    """Return the part of a script that runs when it is started."""
    for node in module.tree.body:
        if isinstance(node, ast.If) and "__name__" in ast.unparse(node.test)[:60]:
            return node
    return None


def only_call(guard: ast.If | None) -> str | None:
    """Return the name of the function that the guard calls, if that is all it does."""
    if guard is None or len(guard.body) != 1 or not isinstance(guard.body[0], ast.Expr):
        return None
    call = guard.body[0].value
    if isinstance(call, ast.Call) and call.args and isinstance(call.args[0], ast.Call):
        call = call.args[0]
    return call.func.id if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) else None


def _called_plainly(guard: ast.If | None) -> str | None:
    """Return the name of the function that the guard calls without arguments, if that is all it does."""
    name = only_call(guard)
    text = "" if guard is None or name is None else ast.unparse(guard.body[0])
    return name if text in (f"{name}()", f"sys.exit({name}())", f"exit({name}())") else None


def _spins(body: list[ast.stmt], *, is_deep: bool = False) -> bool:
    """Return whether statements start rclpy."""
    return any(
        isinstance(each, ast.Call)
        and isinstance(each.func, ast.Attribute)
        and ast.unparse(each.func) == "rclpy.init"
        for node in body
        if is_deep or isinstance(node, (ast.Expr, ast.Try, ast.With, ast.Assign))
        for each in ast.walk(node)
    )


def different(
    programs: list[Program], given: Mapping[str, Mapping[str, object]], modules: Modules
) -> tuple[list[Program], list[tuple[Program, Program]]]:
    """Return the programs that do something else than others, and the others with the one they are like.

    An installed script may also be an entry point: both call one function. They differ if launch files give
    them different parameters.
    """
    groups: dict[tuple[str, str | None], list[Program]] = {}
    for each in programs:
        module = modules.module(each.path)
        called = None if module is None else each.function or _called_plainly(guard_of(module))
        groups.setdefault((each.path, called), []).append(each)
    same: dict[Program, Program] = {}
    for (_, called), group in groups.items():
        by_values = sorted(group, key=lambda each: not given.get(each.full))
        for each in by_values[1:] if called is not None else ():
            values = given.get(each.full)
            if not values or values == given.get(by_values[0].full):
                same[each] = by_values[0]
    return [each for each in programs if each not in same], list(same.items())
