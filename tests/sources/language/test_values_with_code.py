"""Keys, members of enumerations, fields and elements whose classes have code of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

KEY = """
class K:
    def __init__(self, n): self.n = n
    def __hash__(self):
        self.n.ask()
        return 1
"""
"""A class whose hash has an effect."""

IDIOMS = {
    "hash_dict": Idiom(
        """
{K(self): 1}
""",
        before=KEY,
    ),
    "hash_set_add": Idiom(
        """
s = set()
s.add(K(self))
""",
        before=KEY,
    ),
    "hash_in": Idiom(
        """
return K(self) in self.d
""",
        init="""
self.d = {}
""",
        before=KEY,
    ),
    "hash_get": Idiom(
        """
self.d.get(K(self))
""",
        init="""
self.d = {}
""",
        before=KEY,
    ),
    "hash_sub": Idiom(
        """
self.d[K(self)] = 1
""",
        init="""
self.d = {}
""",
        before=KEY,
    ),
    "dc_kw_only": Idiom(
        """
self.j.run()
""",
        init="""
self.j = Job(self.ask, name='a')
""",
        before="""
@dataclass(kw_only=True)
class Base:
    name: str = ''
@dataclass
class Job(Base):
    run: Callable = None
""",
    ),
    "dc_order_sort": Idiom(
        """
sorted([Job(2, self), Job(1, self)])
""",
        before="""
@dataclass
class Job:
    p: int
    n: object
    def __lt__(self, o):
        self.n.ask()
        return self.p < o.p
""",
    ),
    "dc_asdict": Idiom(
        """
d = dataclasses.asdict(self.j)
d['run']()
""",
        init="""
self.j = Job(self.ask)
""",
        before="""
@dataclass
class Job:
    run: Callable
""",
    ),
    "dc_astuple": Idiom(
        """
a, b = dataclasses.astuple(self.j)
b()
""",
        init="""
self.j = Job(1, self.ask)
""",
        before="""
@dataclass
class Job:
    x: int
    run: Callable
""",
    ),
    "enum_partial": Idiom(
        """
Act.GO.value(self)
""",
        before="""
def do(n): n.ask()
class Act(Enum):
    GO = partial(do)
""",
    ),
    "enum_member_fn": Idiom(
        """
Act.GO.value(self)
""",
        before="""
def do(n): n.ask()
class Act(Enum):
    GO = enum.member(do)
""",
    ),
    "enum_init": Idiom(
        """
Act.GO.run(self)
""",
        before="""
class Act(Enum):
    GO = ('go', lambda n: n.ask())
    def __init__(self, label, run):
        self.label = label
        self.run = run
""",
    ),
    "enum_init_iter": Idiom(
        """
for a in Act:
    a.run(self)
""",
        before="""
class Act(Enum):
    GO = ('go', lambda n: n.ask())
    def __init__(self, label, run):
        self.label = label
        self.run = run
""",
    ),
    "enum_missing": Idiom(
        """
Act('x')
""",
        init="""
NODE.append(self)
""",
        before="""
NODE = []
class Act(Enum):
    GO = 1
    @classmethod
    def _missing_(cls, v):
        NODE[0].ask()
        return cls.GO
""",
    ),
    "enum_members_dict": Idiom(
        """
Act.__members__['GO'].do(self)
""",
        before="""
class Act(Enum):
    GO = 1
    def do(self, n): n.ask()
""",
    ),
    "dict_missing": Idiom(
        """
self.t['x']
""",
        init="""
self.t = T(self)
""",
        before="""
class T(dict):
    def __init__(self, n):
        super().__init__()
        self.n = n
    def __missing__(self, k): return self.n.ask()
""",
    ),
    "old_iter_getitem": Idiom(
        """
for x in self.t:
    pass
""",
        init="""
self.t = T(self)
""",
        before="""
class T:
    def __init__(self, n): self.n = n
    def __getitem__(self, k):
        if k > 3: raise IndexError
        return self.n.ask()
""",
    ),
    "sequence_abc": Idiom(
        """
for x in self.t:
    pass
""",
        init="""
self.t = T(self)
""",
        before="""
import collections.abc
class T(collections.abc.Sequence):
    def __init__(self, n): self.n = n
    def __getitem__(self, k): return self.n.ask()
    def __len__(self): return 3
""",
    ),
    "generic_class": Idiom(
        """
Box[int](self.ask).run()
""",
        before="""
T = typing.TypeVar('T')
class Box(typing.Generic[T]):
    def __init__(self, f): self.f = f
    def run(self): self.f()
""",
    ),
    "fn_attr": Idiom(
        """
self.work.fn()
""",
        init="""
def w(): pass
w.fn = self.ask
self.work = w
""",
        methods="""
def setup(self):
    pass
""",
    ),
    "fn_attr_static": Idiom(
        """
tick2.f = self.ask
tick2()
""",
        before="""
def tick2():
    tick2.f()
""",
    ),
    "chained_cmp_obj": Idiom(
        """
return 0 < V(self) < 5
""",
        before="""
class V:
    def __init__(self, n): self.n = n
    def __gt__(self, o): return self.n.ask()
    def __lt__(self, o): return True
""",
    ),
    "pow_obj": Idiom(
        """
return V(self) ** 2
""",
        before="""
class V:
    def __init__(self, n): self.n = n
    def __pow__(self, o): return self.n.ask()
""",
    ),
    "floordiv_obj": Idiom(
        """
return V(self) // 2
""",
        before="""
class V:
    def __init__(self, n): self.n = n
    def __floordiv__(self, o): return self.n.ask()
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_runs_the_code_of_its_values(tmp_path: Path, name: str) -> None:
    """The code was lost."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
