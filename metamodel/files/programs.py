"""Python programs that build models: the parameters of their function ``build`` are those of the model.

A file such as ``fleet.py`` defines ``build(robots: int = 3) -> SystemModel``; ``robots=5`` is one more form
of setting for such a model. A program runs with the rights of the user who names it, and nothing else runs
one.
"""

from __future__ import annotations

import inspect
import math
import sys
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType

from dineros.metamodel import pn
from dineros.metamodel.errors import (
    DinerosError,
    FeatureValueError,
    Location,
    UnknownFeatureError,
    near_matches,
)
from dineros.metamodel.files.reading import read_bytes

SUFFIX = ".py"
_TRUTH = {"true": True, "false": False}


@dataclass(frozen=True)
class ModelProgram:
    """A function that builds a model.

    Attributes
    ----------
    build : callable
        Returns the model; each of its parameters has a default, a whole number, a number, a truth value or a
        text, whose kind its values have.
    path : Path or None
        The file that it is in.
    """

    build: Callable[..., pn.Net]
    path: Path | None = None

    @cached_property
    def parameters(self) -> Mapping[str, int | float | bool | str]:
        """The parameters of the model, with their defaults.

        Raises
        ------
        DinerosError
            A parameter has no default, or one of another kind.
        """
        found = inspect.signature(self.build).parameters.values()
        for each in found:
            if each.kind not in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY) or not isinstance(
                each.default, int | float | bool | str
            ):
                raise self._error(
                    f"the parameter {each.name!r} of build has no default: a number, a text, True or False",
                    hint=f"for example {each.name}: int = 3",
                )
        return {each.name: each.default for each in found}

    def model(self, values: Iterable[str] = ()) -> pn.Net:
        """Return the model for values of its parameters.

        Parameters
        ----------
        values : iterable of str
            ``PARAMETER=VALUE``; of several for one parameter the last.

        Raises
        ------
        DinerosError
            There is no such parameter, a value has another kind, the function fails or returns no model.
        """
        known, given = self.parameters, dict[str, object]()
        for text in values:
            name, _, value = (part.strip() for part in text.partition("="))
            if name not in known:
                hint = near_matches(name, known)
                raise UnknownFeatureError(f"build has no parameter {name!r}", hint=hint)
            given[name] = self._value(name, value)
        return self._built(given)

    def _value(self, name: str, text: str) -> int | float | bool | str:
        """Return a value of the kind of the parameter's default."""
        default = self.parameters[name]
        if isinstance(default, str):
            return text
        try:
            if isinstance(default, bool):
                return _TRUTH[text]
            value: int | float = int(text) if isinstance(default, int) else float(text)
            if not math.isfinite(value):
                raise ValueError
        except (KeyError, ValueError):
            kind = {bool: "true or false", int: "a whole number"}.get(type(default), "a number")
            raise FeatureValueError(f"{name}: takes {kind}, not {text!r}") from None
        return value

    def _built(self, values: Mapping[str, object]) -> pn.Net:
        try:
            model = self.build(**values)
        except DinerosError:
            raise
        except Exception as error:
            raise self._error(f"{type(error).__name__}: {error}", error) from error
        if not isinstance(model, pn.Net):
            raise self._error(f"build returns {model!r}, not a model")
        return model

    def _error(
        self, message: str, error: BaseException | None = None, hint: str | None = None
    ) -> DinerosError:
        where = None if self.path is None else Location(self.path, _line(self.path, error))
        return DinerosError(message, location=where, hint=hint)


def is_of_parameter(setting: str) -> bool:
    """Return whether a setting is of a parameter, ``robots=3``; one of an element has a dot."""
    return setting.partition("=")[0].strip().isidentifier() and not setting.startswith("middleware=")


def is_program(path: Path) -> bool:
    """Return whether a file is a program, by its name."""
    return path.suffix == SUFFIX


def load_program(path: Path) -> ModelProgram:
    """Run a Python file, and return its function ``build``.

    Raises
    ------
    DinerosError
        The file cannot be read or run, or defines no such function.
    """
    build = getattr(run_file(path, f"model of {path.name}"), "build", None)
    if not callable(build):
        raise DinerosError(
            "defines no function build",
            location=Location(path),
            hint="def build(robots: int = 3) -> sym.SystemModel, which returns the model",
        )
    return ModelProgram(build, path)


def run_file(path: Path, name: str) -> ModuleType:
    """Run a Python file of a user; it may import modules next to it.

    Raises
    ------
    DinerosError
        The file cannot be read, or fails, with the line.
    """
    source = read_bytes(path)
    module = ModuleType(name)
    module.__file__ = str(path.resolve())
    sys.modules[name] = module  # where dataclasses look for their module
    # At the end: a `resource.py` next to the file must not take the place of Python's.
    before = list(sys.path)
    sys.path.append(str(path.parent))
    try:
        exec(compile(source, str(path), "exec"), module.__dict__)
    except DinerosError:
        raise
    except SyntaxError as error:
        raise DinerosError(f"is not Python: {error.msg}", location=Location(path, error.lineno)) from error
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        raise DinerosError(text, location=Location(path, _line(path, error))) from error
    finally:
        sys.path[:] = before
    return module


def _line(path: Path, error: BaseException | None) -> int | None:
    """Return the last line of a file that an exception came through."""
    if error is None:
        return None
    frames = traceback.extract_tb(error.__traceback__)
    return next((frame.lineno for frame in reversed(frames) if frame.filename == str(path)), None)
