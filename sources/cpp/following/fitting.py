"""How well arguments fit the parameters of one of several constructors."""

from __future__ import annotations

import re

from dineros.sources.cpp.values import Const, Items, Lambda, Made, Method, Obj, Seconds, Value

_WHOLE = re.compile(r"(?:std::)?(?:unsigned|signed|int|long|short|u?int\d+_t|size_t|char)")
_FLOAT = re.compile(r"(?:double|float|long double)")
_TEXT = re.compile(r"(?:std::)?(?:basic_)?(?:string|string_view)|(?:const )?char\*")
_BOOL = re.compile(r"bool")
_ORDERS = {
    bool: (_BOOL, _WHOLE, _FLOAT),
    int: (_WHOLE, _FLOAT, _BOOL),
    float: (_FLOAT, _WHOLE),
    str: (_TEXT,),
}
"""By the type of a constant: the types of parameters that fit, the best first."""
_PLAIN = (_WHOLE, _FLOAT, _TEXT, _BOOL)
_NEVER = -100
_LENGTHS = ("duration", "Duration", "seconds", "minutes", "hours")


def fits(kind: str, value: Value, classes: list[str]) -> int:
    """Return how well a value fits the type of a parameter: 0 if that is not known, below 0 if it does not.

    Parameters
    ----------
    kind : str
        The type, with a star for a pointer of any kind; empty: not known.
    value : Value
        The argument.
    classes : list of str
        Of an object: its class, and the classes that it extends.

    Examples
    --------
    >>> fits("int", Const(1), []), fits("std::string", Const(1), []), fits("Pose", Const(1), [])
    (4, -100, 0)
    """
    is_plain = any(each.fullmatch(kind) for each in _PLAIN)
    if isinstance(value, Const):
        if value.value is None:  # a null pointer
            return _NEVER if is_plain and not kind.endswith("*") else int(kind.endswith("*"))
        orders = _ORDERS.get(type(value.value), ())
        found = next((at for at, each in enumerate(orders) if each.fullmatch(kind)), None)
        return 4 - found if found is not None else _NEVER if is_plain else 0
    if isinstance(value, Obj) and classes:
        own = kind.removesuffix("*")
        found = next((at for at, each in enumerate(classes) if f"::{each}".endswith(f"::{own}")), None)
        return 0 if not own else 4 - min(found, 2) if found is not None else _NEVER if is_plain else 0
    if isinstance(value, (Lambda, Method)):
        return _NEVER if is_plain else int("function" in kind)
    if isinstance(value, Items):
        return _NEVER if is_plain or (value.of and kind.startswith("rclcpp::")) else 0
    if isinstance(value, Seconds):
        return 2 if kind.endswith(_LENGTHS) else 0
    if isinstance(value, Made) and kind and value.path:
        is_other = value.path.startswith("std::") and kind.startswith("rclcpp::")
        return 4 if kind.removesuffix("*") == value.path else _NEVER if is_other else 0
    return 0
