"""What classes, their bases, metaclasses and decorators do when classes and instances are made."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "init_subclass": Idiom(
        """
for c in Plug.known:
    c().run(self)
""",
        before="""
class Plug:
    known = []
    def __init_subclass__(cls, **kw):
        super().__init_subclass__(**kw)
        Plug.known.append(cls)
class Ask(Plug):
    def run(self, n): n.ask()
""",
    ),
    "init_subclass_dict": Idiom(
        "Plug.known['ask']().run(self)",
        before="""
class Plug:
    known = {}
    def __init_subclass__(cls, name=None, **kw):
        cls.known[name] = cls
class Ask(Plug, name='ask'):
    def run(self, n): n.ask()
""",
    ),
    "subclasses": Idiom(
        """
for c in Plug.__subclasses__():
    c().run(self)
""",
        before="""
class Plug:
    pass
class Ask(Plug):
    def run(self, n): n.ask()
""",
    ),
    "metaclass_registry": Idiom(
        "Meta.known['Ask']().run(self)",
        before="""
class Meta(type):
    known = {}
    def __new__(mcs, name, bases, ns):
        cls = super().__new__(mcs, name, bases, ns)
        Meta.known[name] = cls
        return cls
class Ask(metaclass=Meta):
    def run(self, n): n.ask()
""",
    ),
    "metaclass_init": Idiom(
        """
for c in known:
    c().run(self)
""",
        before="""
known = []
class Meta(type):
    def __init__(cls, name, bases, ns):
        super().__init__(name, bases, ns)
        known.append(cls)
class Ask(metaclass=Meta):
    def run(self, n): n.ask()
""",
    ),
    "metaclass_call": Idiom(
        "Ask(self)",
        before="""
class Meta(type):
    def __call__(cls, n):
        n.ask()
        return super().__call__(n)
class Ask(metaclass=Meta):
    def __init__(self, n): pass
""",
    ),
    "singleton_meta": Idiom(
        "Ask(self).run()",
        before="""
class Meta(type):
    _i = {}
    def __call__(cls, *a):
        if cls not in cls._i:
            cls._i[cls] = super().__call__(*a)
        return cls._i[cls]
class Ask(metaclass=Meta):
    def __init__(self, n): self.n = n
    def run(self): self.n.ask()
""",
    ),
    "dunder_new": Idiom(
        "Ask(self)",
        before="""
class Ask:
    def __new__(cls, n):
        n.ask()
        return object.__new__(cls)
    def __init__(self, n): pass
""",
    ),
    "dunder_new_singleton": Idiom(
        "Ask().run(self)",
        before="""
class Ask:
    _i = None
    def __new__(cls, *a):
        if cls._i is None:
            cls._i = super().__new__(cls)
        return cls._i
    def run(self, n): n.ask()
""",
    ),
    "dataclass_initvar": Idiom(
        "Job(self)",
        before="""
@dataclasses.dataclass
class Job:
    n: dataclasses.InitVar[object]
    x: int = 0
    def __post_init__(self, n):
        n.ask()
""",
    ),
    "type_self": Idiom("type(self).work(self)", methods="def work(self): self.ask()"),
    "type_obj_new": Idiom(
        "type(self.d)(self).run()",
        init="self.d = Do(self)",
        before="""
class Do:
    def __init__(self, n): self.n = n
    def run(self): self.n.ask()
""",
    ),
    "type_three": Idiom(
        """
d = Do()
d.n = self
d.run()
""",
        before="""
def run(self): self.n.ask()
Do = type('Do', (), {'run': run})
""",
    ),
    "class_attr_assigned_later": Idiom(
        "self.work()",
        methods="def work(self): pass",
        after="""
def other(self):
    self.ask()
Robot.work = other
""",
    ),
    "class_decorator_wrap": Idiom(
        "self.work()",
        methods="def work(self): pass",
        before="""
def wrap(cls):
    old = cls.work
    def new(self):
        self.ask()
        return old(self)
    cls.work = new
    return cls
""",
        decorator="@wrap",
    ),
    "class_decorator_setattr": Idiom(
        "self.work()",
        before="""
def wrap(cls):
    def work(self):
        self.ask()
    setattr(cls, 'work', work)
    return cls
""",
        decorator="@wrap",
    ),
    "method_alias_class": Idiom("self.go()", methods="go = None", after="Robot.go = Robot.ask"),
    "enum_method": Idiom(
        "E.A.run(self)",
        before="""
import enum
class E(enum.Enum):
    A = 1
    def run(self, n): n.ask()
""",
    ),
    "enum_iter": Idiom(
        """
for e in E:
    e.run(self)
""",
        before="""
import enum
class E(enum.Enum):
    A = 1
    B = 2
    def run(self, n): n.ask()
""",
    ),
    "enum_lookup": Idiom(
        "E(1).run(self)",
        before="""
import enum
class E(enum.Enum):
    A = 1
    def run(self, n): n.ask()
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
