"""Compiled kernels: cached between runs, and compiled again if any of their sources has changed.

Numba stores compiled code next to a kernel's own file, and checks whether that file has changed. It does not
check functions that a kernel calls or inlines from other files, nor their constants: after an update, an old
kernel could run on new tables, or its index could refer to a class that no longer exists. So the name of the
cache folder is a hash of all these files.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

ROOM = Path(__file__).resolve().parents[1]
_PREFIX = "dineros-kernels-"
_IMPORTED = re.compile(rb"^from dineros\.analysis\.([\w.]+) import", re.MULTILINE)


def kernel(**options: Any) -> Any:
    """Return a decorator that compiles a function at its first call, or loads its compiled code."""
    from numba import njit

    options = {"no_cfunc_wrapper": True, **options}  # no code calls a kernel by its C address

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = _for_all_numbers(njit(**options)(function))
        dispatcher._cache = _OpenedWhenCalled(dispatcher)
        return dispatcher

    return decorate


class _OpenedWhenCalled:
    """The cache of a kernel that nothing has called from Python yet; the first call opens it.

    Opening takes as long as importing a module, and most kernels are called by other kernels only.
    """

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher

    def load_overload(self, arguments: Any, target: Any) -> Any:
        """Open the cache of numba, or none where no folder is writable, and load from it."""
        from numba import config

        settings: Any = config
        dispatcher, folder = self._dispatcher, kept_in()
        if folder is None:
            return None
        former = settings.CACHE_DIR
        settings.CACHE_DIR = str(folder)
        try:
            dispatcher.enable_caching()
        finally:
            settings.CACHE_DIR = former
        _loaded_alone(_kept_by_one_at_a_time(dispatcher, folder))
        return dispatcher._cache.load_overload(arguments, target)

    def save_overload(self, *_: object) -> None:
        """Save nothing: no folder is writable."""


def _for_all_numbers(dispatcher: Any) -> Any:
    """Let the callers of a kernel share one compilation of it.

    By default, Numba compiles it again for each constant argument in a call, and for narrower number types.
    """
    from numba import types

    plain: Callable[[Any], Any] = types.unliteral
    template_for = dispatcher.get_call_template

    def get_call_template(given: Iterable[Any], named: Any) -> Any:
        shared = (types.int64 if plain(one) == types.int32 else plain(one) for one in given)
        return template_for(tuple(shared), named)

    dispatcher.get_call_template = get_call_template
    return dispatcher


def _kept_by_one_at_a_time(dispatcher: Any, folder: Path) -> Any:
    """Let one process at a time write kernels; if writing fails, a kernel is compiled again next time.

    Left alone, two processes that compile a kernel for different arguments may choose the same file for both.
    """
    kept = dispatcher._cache
    keep = kept.save_overload

    def save_overload(*compiled: Any) -> None:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            lock = os.open(folder, os.O_RDONLY)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX)
                keep(*compiled)
            finally:
                os.close(lock)

    kept.save_overload = save_overload
    return dispatcher


def _loaded_alone(dispatcher: Any) -> Any:
    """Load a cached kernel without the parts of Numba that only compilation needs: all types and functions.

    By default, Numba imports and registers these before it checks whether there is anything to compile, which
    takes longer than small nets do. Its compiler requests them itself.
    """
    kept = dispatcher._cache

    def load_overload(arguments: Any, target: Any) -> Any:
        _name_allocating_functions()
        return kept._load_overload(arguments, target)

    kept.load_overload = load_overload
    return dispatcher


@cache
def _name_allocating_functions() -> None:
    """Let cached kernels find the functions in C with which they allocate arrays.

    Numba does this when it prepares its compiler, for which it then compiles functions that count references.
    A cached kernel contains those that it calls.
    """
    from llvmlite.binding import add_symbol
    from numba.core.runtime import nrt

    runtime: Any = nrt
    for name, address in runtime._nrt.c_helpers.items():
        add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


def kept_in() -> Path | None:
    """Return the folder of the kernels of this version; None: there is no writable one."""
    from numba import config

    settings: Any = config
    return _folder(settings.CACHE_DIR or None)


@cache
def _folder(given: str | None) -> Path | None:
    """Return the folder for cached kernels; None: none is writable."""
    name = f"{_PREFIX}{digest(sources(ROOM))}"
    homes = [Path(given)] if given else [ROOM / "__pycache__", user_cache()]
    return next((folder for home in homes if (folder := made(home, name))), None)


def sources(room: Path) -> list[Path]:
    """Return the files of all kernels below a folder, and the files from which they import."""
    found = sorted(room.glob("**/kernels/*.py"))
    others = {
        room.joinpath(*name.decode().split(".")).with_suffix(".py")
        for file in found
        for name in _IMPORTED.findall(file.read_bytes())
    }
    return [*found, *sorted(other for other in others - set(found) if other.is_file())]


def digest(files: Iterable[Path]) -> str:
    """Return a hash that changes whenever a file is changed, added or removed."""
    known = hashlib.blake2b(digest_size=8)
    for file in files:
        known.update(b"%s\0%s\0" % (file.name.encode(), hashlib.blake2b(file.read_bytes()).digest()))
    return known.hexdigest()


def user_cache() -> Path:
    """Return the folder for data that can be computed again (XDG Base Directory Specification)."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(home) if os.path.isabs(home) else Path("~/.cache").expanduser()) / "dineros"  # noqa: PTH117


def made(home: Path, name: str) -> Path | None:
    """Create a folder for kernels, and remove those of other versions next to it; None if impossible."""
    folder = home / name
    try:
        is_new = not folder.is_dir()
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return None
    if is_new:
        for other in home.glob(f"{_PREFIX}*"):
            if other != folder and not other.is_symlink():
                shutil.rmtree(other, ignore_errors=True)
    return folder
