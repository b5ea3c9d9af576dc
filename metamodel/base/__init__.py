"""The base of all classes of the typed API: typed features, and errors for misspelled ones.

pyecore accepts any attribute on a model object; here an unknown one is refused with similar names,
enumeration values may be given by name, and an error for a value of the wrong type names the feature. The
generated packages (`pn`, `sym`, `rtm`, `pnm`, `trace`) use nothing else of `metamodel`.
"""

# ruff: noqa: D102, N802, N815  (the static views repeat pyecore's names and document nothing new)

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar, cast

from pyecore.ecore import EAttribute, EDataType, EDouble, EDoubleObject, EEnum, EReference
from pyecore.resources import global_registry
from pyecore.valuecontainer import BadValueError

from dineros.metamodel.base import storage
from dineros.metamodel.base.storage import is_heard, set_attribute, set_reference
from dineros.metamodel.errors import FeatureValueError, UnknownFeatureError, near_matches

if TYPE_CHECKING:
    from dineros.metamodel.base.storage import MetaEClass

    class EObject:
        """Static view of a pyecore model object."""

        eClass: Any

        def eContainer(self) -> EObject | None: ...
        def eContainmentFeature(self) -> Any: ...
        def eIsSet(self, feature: str) -> bool: ...
        def eAllContents(self) -> Iterator[EObject]: ...
        @property
        def eContents(self) -> list[EObject]: ...
        def delete(self, recursive: bool = True) -> None: ...

    class EnumLiteral:
        """Static view of the literal of an enumeration; `str()` returns its name."""

        name: str
        value: int

else:
    from pyecore.ecore import EEnumLiteral as EnumLiteral
    from pyecore.ecore import EObject

    class MetaEClass(storage.MetaEClass):
        """Metaclass of model classes: all get our own way to set, notify and show."""

        def __init__(self, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> None:
            super().__init__(name, bases, namespace)
            if not any(isinstance(base, MetaEClass) for base in bases):
                self.__init__ = initialise
                self.__setattr__ = refuse_unknown
                self.notify = notify_listeners
                self.__repr__ = show


T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])

__all__ = [
    "Choice",
    "EObject",
    "EnumLiteral",
    "Mandatory",
    "MetaEClass",
    "ModelList",
    "complete",
    "enumeration",
    "features_of",
    "literals_of",
    "reference",
    "remembered",
]


class Choice(Generic[T]):
    """Static view of an attribute whose value is a literal of an enumeration, which may be given by name."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type | None = None) -> T: ...
        def __set__(self, instance: object, value: T | str) -> None: ...


class Mandatory(Generic[T]):
    """Static view of a reference that every valid model sets; it may be None while a model is built."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type | None = None) -> T: ...
        def __set__(self, instance: object, value: T | None) -> None: ...


class ModelList(Generic[T]):
    """Static view of a many-valued feature: an ordered set that updates opposites and containers."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type | None = None) -> Self: ...
        def __set__(self, instance: object, value: Iterable[T]) -> None: ...
        def append(self, value: T) -> None: ...
        def extend(self, values: Iterable[T]) -> None: ...
        def insert(self, index: int, value: T) -> None: ...
        def remove(self, value: T) -> None: ...
        def clear(self) -> None: ...
        def index(self, value: T) -> int: ...
        def __iter__(self) -> Iterator[T]: ...
        def __len__(self) -> int: ...
        def __contains__(self, value: object) -> bool: ...
        def __getitem__(self, index: int) -> T: ...


_NUMBERS = (EDouble, EDoubleObject)
_MANY, _ONE = object(), object()
"""Placeholders for the defaults of many-valued and single-valued references."""


def remembered(function: F) -> F:
    """Cache the results of a function of a class; like `functools.cache`, with types that mypy accepts."""
    return cast(F, cache(function))


@remembered
def features_of(cls: type[EObject]) -> dict[str, Any]:
    """Return the structural features of a model class by name."""
    return {feature.name: feature for feature in cls.eClass.eAllStructuralFeatures()}


def refuse_unknown(self: EObject, name: str, value: object) -> None:
    """Set a feature; the `__setattr__` of every model class.

    Raises
    ------
    UnknownFeatureError
        The class has no such feature.
    FeatureValueError
        The value does not fit the feature's type.
    """
    if name[0] == "_":
        object.__setattr__(self, name, value)
        return
    feature = features_of(type(self)).get(name)
    if feature is None:
        if name in ("listeners", "dyn_inst"):  # pyecore's own attributes without an underscore
            object.__setattr__(self, name, value)
            return
        kind = type(self).__name__
        known = features_of(type(self))
        raise UnknownFeatureError(f"{kind} has no feature {name!r}", hint=near_matches(name, known))
    try:
        if isinstance(feature, EAttribute):
            set_attribute(self, feature, _converted(feature, value))
        else:
            object.__setattr__(self, name, value)
    except BadValueError as error:
        raise _wrong_value(self, feature, value) from error


def _converted(feature: Any, value: object) -> object:
    """Return the literal with a name, the float for an integer, or the value itself."""
    if isinstance(value, str) and isinstance(feature._eType, EEnum):
        return _literal(feature, value)
    return float(value) if type(value) is int and feature._eType in _NUMBERS else value


@cache
def literals_of(etype: Any) -> dict[str, object]:
    """Return the literals of an enumeration by name."""
    return {str(literal): literal for literal in etype.eLiterals}


def _literal(feature: Any, name: str) -> object:
    literals = literals_of(feature._eType)
    literal = literals.get(name)
    if literal is None:
        names = list(literals)
        raise FeatureValueError(
            f"{feature.name} must be one of {', '.join(names)}, not {name!r}", hint=near_matches(name, names)
        )
    return literal


def _wrong_value(self: EObject, feature: Any, value: object) -> FeatureValueError:
    shown = repr(value) if isinstance(value, (str, int, float, bool)) else type(value).__name__
    etype = feature._eType
    expected = etype.__name__ if isinstance(etype, type) else etype.name
    many = "a list of " if feature.many else ""
    return FeatureValueError(f"{type(self).__name__}.{feature.name} takes {many}{expected}, not {shown}")


def initialise(self: EObject, **features: Any) -> None:
    """Set features, attributes before references; the `__init__` of every model class.

    Raises
    ------
    UnknownFeatureError
        A keyword is not a feature of the class.
    FeatureValueError
        A value does not fit its feature's type.
    """
    plan = _plan_of(type(self))
    held = self.__dict__
    later = []
    for name, value in features.items():
        known = plan.get(name)
        if known is None:
            refuse_unknown(self, name, value)
        elif value is None or value is known[2]:
            continue
        elif value.__class__ is known[3]:  # it fits, and there are no listeners to a new object
            if value != known[2]:
                held[name] = value
                held["_isset"][known[1]] = None
        else:
            later.append((known, name, value))
    later.sort()  # by their turns, each of which is there once
    for (_, feature, default, _), name, value in later:
        if default is _MANY or default is _ONE:
            try:
                if default is _MANY:
                    getattr(self, name).extend(value)
                else:
                    set_reference(self, feature, value)
            except (BadValueError, TypeError) as error:
                raise _wrong_value(self, feature, value) from error
        elif value.__class__ is not default.__class__ or value != default:
            refuse_unknown(self, name, value)


@remembered
def _plan_of(cls: type[EObject]) -> dict[str, tuple[int, Any, object, type | None]]:
    """Return of each feature of a model class its turn, itself, its default, and the class of its values.

    Attributes come before references. The class is that of Python, None for other features than attributes.
    """
    features = sorted(features_of(cls).items(), key=lambda item: item[1].is_reference)
    return {
        name: (
            turn,
            feature,
            feature.get_default_value() if feature.is_attribute else _MANY if feature.many else _ONE,
            _class_of_values(feature),
        )
        for turn, (name, feature) in enumerate(features)
    }


def _class_of_values(feature: Any) -> type | None:
    """Return the Python class of all values of an attribute, None if another test must decide."""
    if type(feature._eType) is EDataType:
        return cast("type | None", feature._eType.eType)
    return None


def notify_listeners(changed: Any, notification: object) -> None:
    """Notify listeners of a change; the `notify` of every model class.

    pyecore searches the resource of an object at each change, which takes many calls and an exception if
    there is none, as usual. The first parameter is not named `self`, since the function would then become an
    operation of the metamodel.
    """
    if is_heard(changed):
        EObject.notify(changed, notification)  # type: ignore[attr-defined]


def show(self: EObject) -> str:
    """Return a short text such as ``<sym.Place Ready>``; the `__repr__` of every model class."""
    identity = getattr(self, "id", None) or getattr(self, "name", None) or ""
    package = type(self).__module__.rpartition(".")[2]
    return f"<{package}.{type(self).__name__} {identity}>".replace(" >", ">")


_named: list[tuple[Any, str, str | None]] = []
"""References of the package that is being imported: each with the names of its type and of its opposite."""


def reference(type: str, opposite: str | None = None, **qualifiers: Any) -> Any:
    """Make a reference to a class that its package may define later.

    Parameters
    ----------
    type : str
        Name of the class, with its package if that is another one.
    opposite : str, optional
        The reference of that class that leads back, named by one of the two.
    **qualifiers
        Arguments of pyecore's `EReference`.
    """
    made = EReference(**qualifiers)
    _named.append((made, type, opposite))
    return made


def enumeration(cls: type[T]) -> type[T]:
    """Make the enumeration that a class describes: its literals are annotated, and numbered from 0."""
    return cast("type[T]", EEnum(cls.__name__, literals=list(cls.__annotations__)))


def complete(module: Any) -> None:
    """Connect the classes of a package, now that all exist, and let files name it."""
    names = vars(module)
    for made, type, _ in _named:
        package, _, name = type.rpartition(".")
        made.eType = getattr(names[package], name) if package else names[name]
    for made, _, opposite in _named:
        if opposite is not None:
            made.eOpposite = getattr(made.eType, opposite)
    _named.clear()
    for value in list(names.values()):
        if isinstance(value, EEnum):
            module.eClassifiers[value.name] = value
            module.eClass.eClassifiers.append(value)
    global_registry[module.nsURI] = module
