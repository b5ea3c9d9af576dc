"""Names of Boost that the standard library has, too."""

from __future__ import annotations

_NAMES = {
    *("make_shared", "make_unique", "shared_ptr", "unique_ptr", "weak_ptr", "enable_shared_from_this"),
    *("static_pointer_cast", "dynamic_pointer_cast", "const_pointer_cast"),
    *("bind", "mem_fn", "function", "ref", "cref", "move", "forward", "placeholders", "get"),
    *("thread", "this_thread", "mutex", "timed_mutex", "recursive_mutex", "shared_mutex"),
    *("lock_guard", "unique_lock", "shared_lock", "condition_variable", "condition_variable_any"),
    *("promise", "future", "shared_future", "packaged_task", "async", "barrier", "latch"),
    *("array", "unordered_map", "unordered_set", "tuple", "make_tuple", "tie"),
}
"""First parts of names that mean the same in ``boost`` and in ``std``."""
_BOOST = "boost::"


def standard(path: str) -> str:
    """Return the name that the standard library has for what Boost defines; other names as they are.

    Examples
    --------
    >>> standard("boost::make_shared"), standard("boost::asio::io_context")
    ('std::make_shared', 'boost::asio::io_context')
    """
    if not path.startswith(_BOOST):
        return path
    rest = path.removeprefix(_BOOST)
    return f"std::{rest}" if rest.partition("::")[0] in _NAMES else path
