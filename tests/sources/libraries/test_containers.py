"""Functions in containers of the standard library, and behind weak references."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "weakref_finalize_call": Idiom(
        "self.fin()", init="self.fin = weakref.finalize(self, self.ask)", before="import weakref"
    ),
    "weakmethod": Idiom(
        "self.wm()()", init="self.wm = weakref.WeakMethod(self.ask)", before="import weakref"
    ),
    "weakref_ref": Idiom("self.me().ask()", init="self.me = weakref.ref(self)", before="import weakref"),
    "weakref_proxy": Idiom("self.me.ask()", init="self.me = weakref.proxy(self)", before="import weakref"),
    "weakset": Idiom(
        """
for x in self.all:
    x.ask()
""",
        init="""
self.all = weakref.WeakSet()
self.all.add(self)
""",
        before="import weakref",
    ),
    "weakvaluedict": Idiom(
        "self.all['a'].ask()",
        init="""
self.all = weakref.WeakValueDictionary()
self.all['a'] = self
""",
        before="import weakref",
    ),
    "defaultdict_list": Idiom(
        """
for f in self.h['a']:
    f()
""",
        init="""
self.h = defaultdict(list)
self.h['a'].append(self.ask)
""",
        before="from collections import defaultdict",
    ),
    "chainmap": Idiom(
        "self.h['a']()",
        init="self.h = ChainMap({'a': self.ask}, {})",
        before="from collections import ChainMap",
    ),
    "ordereddict_init": Idiom(
        """
for k, f in self.h.items():
    f()
""",
        init="self.h = OrderedDict([('a', self.ask)])",
        before="from collections import OrderedDict",
    ),
    "dict_pairs": Idiom("self.h['a']()", init="self.h = dict([('a', self.ask)])"),
    "dict_fromkeys": Idiom("self.h['a']()", init="self.h = dict.fromkeys(['a'], self.ask)"),
    "dict_zip": Idiom("self.h['a']()", init="self.h = dict(zip(['a'], [self.ask]))"),
    "dict_or": Idiom("self.h['a']()", init="self.h = {} | {'a': self.ask}"),
    "list_times": Idiom(
        """
for f in self.h:
    f()
""",
        init="self.h = [self.ask] * 3",
    ),
    "deque_init": Idiom(
        "self.h.popleft()()", init="self.h = deque([self.ask])", before="from collections import deque"
    ),
    "heapq": Idiom(
        """
_, f = heapq.heappop(self.h)
f()
""",
        init="""
self.h = []
heapq.heappush(self.h, (1, self.ask))
""",
        before="import heapq",
    ),
    "simplenamespace": Idiom(
        "self.h.f()", init="self.h = SimpleNamespace(f=self.ask)", before="from types import SimpleNamespace"
    ),
    "typing_namedtuple_unpack": Idiom(
        """
for n, f in self.h:
    f()
""",
        init="self.h = [Job('a', self.ask)]",
        before="""
from typing import NamedTuple, Callable
class Job(NamedTuple):
    name: str
    f: Callable
""",
    ),
    "namedtuple_unpack": Idiom(
        """
n, f = self.h
f()
""",
        init="self.h = Job('a', self.ask)",
        before="""
from collections import namedtuple
Job = namedtuple('Job', 'name f')
""",
    ),
    "namedtuple_replace": Idiom(
        "self.h.f()",
        init="self.h = Job('a', None)._replace(f=self.ask)",
        before="""
from collections import namedtuple
Job = namedtuple('Job', 'name f')
""",
    ),
    "dataclass_replace": Idiom(
        "self.h.f()",
        init="self.h = dataclasses.replace(Job(), f=self.ask)",
        before="""
@dataclasses.dataclass
class Job:
    f: object = None
""",
    ),
    "contextvar": Idiom(
        "V.get().ask()",
        init="V.set(self)",
        before="""
import contextvars
V = contextvars.ContextVar('v')
""",
    ),
    "dict_methods_unknown_key": Idiom(
        "self.table[self.key]()",
        init="""
self.table = {'a': self.ask}
self.key = self.get_name()
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
