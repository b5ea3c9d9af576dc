"""Functions of the standard library that call functions."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "methodcaller": Idiom("operator.methodcaller('ask')(self)", before="import operator"),
    "methodcaller_map": Idiom(
        "list(map(methodcaller('ask'), [self]))", before="from operator import methodcaller"
    ),
    "attrgetter": Idiom("attrgetter('ask')(self)()", before="from operator import attrgetter"),
    "attrgetter_dotted": Idiom(
        "attrgetter('h.n.ask')(self)()",
        init="""
self.h = H()
self.h.n = self
""",
        before="""
from operator import attrgetter
class H: pass
""",
    ),
    "itemgetter": Idiom(
        "itemgetter('a')(self.d)()", init="self.d = {'a': self.ask}", before="from operator import itemgetter"
    ),
    "reduce": Idiom(
        "reduce(self.step, [1, 2, 3])",
        methods="""
def step(self, a, b):
    self.ask()
    return a
""",
        before="from functools import reduce",
    ),
    "reduce_lambda": Idiom(
        "reduce(lambda a, f: f(), [self.ask, self.ask], None)", before="from functools import reduce"
    ),
    "reduce_compose": Idiom(
        """
f = reduce(lambda f, g: lambda: (f(), g()), [self.ask, self.ask])
f()
""",
        before="from functools import reduce",
    ),
    "singledispatch": Idiom(
        "handle(1, self)",
        before="""
from functools import singledispatch
@singledispatch
def handle(x, n): pass
@handle.register
def _(x: int, n): n.ask()
""",
    ),
    "singledispatch_type": Idiom(
        "handle(1, self)",
        before="""
from functools import singledispatch
@singledispatch
def handle(x, n): pass
@handle.register(int)
def _on_int(x, n): n.ask()
""",
    ),
    "singledispatch_base": Idiom(
        "handle('a', self)",
        before="""
from functools import singledispatch
@singledispatch
def handle(x, n): n.ask()
@handle.register(int)
def _on_int(x, n): pass
""",
    ),
    "singledispatchmethod": Idiom(
        "self.handle(1)",
        methods="""
@singledispatchmethod
def handle(self, x): pass
@handle.register
def _(self, x: int): self.ask()
""",
        before="from functools import singledispatchmethod",
    ),
    "cached_property": Idiom(
        "x = self.answer",
        methods="""
@cached_property
def answer(self):
    return self.ask()
""",
        before="from functools import cached_property",
    ),
    "cache_function": Idiom(
        "self.cached()",
        init="self.cached = functools.lru_cache(maxsize=4)(self.ask)",
        before="import functools",
    ),
    "partialmethod": Idiom(
        "self.go()",
        methods="""
def work(self, x): self.ask()
go = partialmethod(work, 1)
""",
        before="from functools import partialmethod",
    ),
    "itertools_chain_for": Idiom(
        """
for f in itertools.chain([self.ask], []):
    f()
""",
        before="import itertools",
    ),
    "itertools_cycle": Idiom(
        "next(self.it)()", init="self.it = itertools.cycle([self.ask])", before="import itertools"
    ),
    "itertools_starmap": Idiom(
        "list(itertools.starmap(self.two, [(1, 2)]))",
        methods="def two(self, a, b): self.ask()",
        before="import itertools",
    ),
    "itertools_takewhile": Idiom(
        "list(itertools.takewhile(self.ok, [1, 2]))",
        methods="def ok(self, a): return self.ask()",
        before="import itertools",
    ),
    "sort_key": Idiom("[1, 2].sort(key=self.key)", methods="def key(self, x): self.ask()"),
    "cmp_to_key": Idiom(
        "sorted([1, 2], key=functools.cmp_to_key(self.cmp))",
        methods="def cmp(self, a, b): self.ask()",
        before="import functools",
    ),
    "bisect_key": Idiom(
        "bisect.bisect([1, 2], 3, key=self.key)",
        methods="def key(self, x): self.ask()",
        before="import bisect",
    ),
    "re_sub": Idiom(
        "re.sub('a', self.repl, 'aaa')",
        methods="""
def repl(self, m):
    self.ask()
    return ''
""",
        before="import re",
    ),
    "json_default": Idiom(
        "json.dumps({}, default=self.conv)", methods="def conv(self, m): self.ask()", before="import json"
    ),
    "callable_iter": Idiom("""
for x in iter(self.ask, None):
    pass
"""),
    "inspect_members": Idiom(
        """
for name, f in inspect.getmembers(self, inspect.ismethod):
    if name.startswith('do_'):
        f()
""",
        methods="def do_a(self): self.ask()",
        before="import inspect",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
