"""Idioms of Python whose effects belong to the callback that uses them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "match_guard": Idiom("""
match 1:
    case x if self.ask():
        pass
    case _:
        pass
"""),
    "match_body_class": Idiom(
        """
match Ev(self.ask):
    case Ev(f=g):
        g()
""",
        before="""
@dataclasses.dataclass
class Ev:
    f: object
""",
    ),
    "match_seq": Idiom("""
match [self.ask, 1]:
    case [f, n]:
        f()
"""),
    "match_map": Idiom("""
match {'f': self.ask}:
    case {'f': g}:
        g()
"""),
    "walrus": Idiom("""
if (r := self.ask()) is not None:
    pass
"""),
    "generator_later": Idiom(
        "next(self.gen)",
        init="self.gen = self.steps()",
        methods="""
def steps(self):
    while True:
        self.ask()
        yield 1
""",
    ),
    "generator_genexp_later": Idiom("next(self.gen)", init="self.gen = (self.ask() for _ in range(10))"),
    "generator_unpack": Idiom(
        "a, b = self.steps()",
        methods="""
def steps(self):
    self.ask()
    yield 1
    yield 2
""",
    ),
    "generator_join": Idiom(
        "','.join(self.steps())",
        methods="""
def steps(self):
    self.ask()
    yield 'a'
""",
    ),
    "generator_in": Idiom(
        "'a' in self.steps()",
        methods="""
def steps(self):
    self.ask()
    yield 'a'
""",
    ),
    "generator_extend": Idiom(
        """
l = []
l.extend(self.steps())
""",
        methods="""
def steps(self):
    self.ask()
    yield 'a'
""",
    ),
    "yield_from": Idiom(
        """
for _ in self.outer():
    pass
""",
        methods="""
def inner(self):
    self.ask()
    yield 1
def outer(self):
    yield from self.inner()
""",
    ),
    "recursion": Idiom(
        "self.down(3)",
        methods="""
def down(self, n):
    if n == 0:
        self.ask()
    else:
        self.down(n - 1)
""",
    ),
    "globals_lookup": Idiom("globals()['work'](self)", before="def work(n): n.ask()"),
    "eval_": Idiom("eval('self.ask()')"),
    "except_type_call": Idiom(
        """
try:
    x = int('a')
except self.kind():
    pass
""",
        methods="""
def kind(self):
    self.ask()
    return ValueError
""",
    ),
    "assert_msg": Idiom("assert self.flag, self.ask()", init="self.flag = False"),
    "fstring_format": Idiom(
        "x = f'{self.d:3}'",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __format__(self, s): return self.n.ask()
""",
    ),
    "percent_str": Idiom(
        "x = '%s' % self.d",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __str__(self): return self.n.ask()
""",
    ),
    "str_format": Idiom(
        "x = '{}'.format(self.d)",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __str__(self): return self.n.ask()
""",
    ),
    "print_str": Idiom(
        "print(self.d)",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __str__(self): return self.n.ask()
""",
    ),
    "slice_key": Idiom(
        "x = self.d[1:2]",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __getitem__(self, k): return self.n.ask()
""",
    ),
    "del_dunder": Idiom(
        """
d = D(self)
del d
""",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __del__(self): self.n.ask()
""",
    ),
    "bool_dunder": Idiom(
        """
if self.d:
    pass
""",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __bool__(self): return self.n.ask()
""",
    ),
    "not_bool_dunder": Idiom(
        "x = not self.d",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __bool__(self): return self.n.ask()
""",
    ),
    "len_bool_dunder": Idiom(
        """
if self.d:
    pass
""",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __len__(self): return self.n.ask()
""",
    ),
    "class_getitem": Idiom(
        "D[self]",
        before="""
class D:
    def __class_getitem__(cls, n): n.ask()
""",
    ),
    "index_dunder": Idiom(
        "x = -self.d",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __neg__(self): return self.n.ask()
""",
    ),
    "round_dunder": Idiom(
        "round(self.d)",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __round__(self, k=0): return self.n.ask()
""",
    ),
    "reversed_dunder": Idiom(
        "reversed(self.d)",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __reversed__(self): return self.n.ask()
""",
    ),
    "await_dunder": Idiom(
        "asyncio.run(self.go())",
        methods="""
async def go(self):
    await D(self)
""",
        before="""
class D:
    def __init__(self, n): self.n = n
    def __await__(self):
        self.n.ask()
        yield
""",
    ),
    "total_ordering": Idiom(
        "x = self.d >= self.d",
        init="self.d = D(self)",
        before="""
import functools
@functools.total_ordering
class D:
    def __init__(self, n): self.n = n
    def __lt__(self, o): return self.n.ask()
    def __eq__(self, o): return True
""",
    ),
    "importlib_own": Idiom(
        "importlib.import_module('helper').work(self)",
        before="import importlib",
        helper="def work(n): n.ask()",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
