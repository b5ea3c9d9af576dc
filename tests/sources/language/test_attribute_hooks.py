"""What classes do when their attributes are set, read and deleted."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "set_descriptor": Idiom(
        "self.speed = 2",
        methods="speed = Field()",
        before="""
class Field:
    def __set__(self, obj, v): obj.ask()
    def __get__(self, obj, t=None): return 1
""",
    ),
    "get_descriptor": Idiom(
        "x = self.speed",
        methods="speed = Field()",
        before="""
class Field:
    def __get__(self, obj, t=None): return obj.ask()
""",
    ),
    "set_descriptor_aug": Idiom(
        "self.speed += 2",
        methods="speed = Field()",
        before="""
class Field:
    def __set__(self, obj, v): obj.ask()
    def __get__(self, obj, t=None): return 1
""",
    ),
    "set_name": Idiom(
        "self.speed = 2",
        methods="speed = Field()",
        before="""
class Field:
    def __set_name__(self, owner, name): self.name = '_' + name
    def __set__(self, obj, v):
        setattr(obj, self.name, v)
        obj.ask()
""",
    ),
    "setattr_dunder": Idiom(
        "self.w.x = 1",
        init="self.w = Watch(self)",
        before="""
class Watch:
    def __init__(self, n):
        object.__setattr__(self, 'n', n)
    def __setattr__(self, k, v):
        self.n.ask()
""",
    ),
    "setattr_dunder_super": Idiom(
        "self.w.x = 1",
        init="self.w = Watch(self)",
        before="""
class Watch:
    def __init__(self, n):
        self.n = n
        self.ready = True
    def __setattr__(self, k, v):
        super().__setattr__(k, v)
        if k == 'x':
            self.n.ask()
""",
    ),
    "setattr_function_property": Idiom(
        "setattr(self, 'speed', 1)",
        methods="""
@property
def speed(self):
    return 1
@speed.setter
def speed(self, v):
    self.ask()
""",
    ),
    "property_call": Idiom(
        "self.speed = 1",
        methods="""
def _get(self): return 1
def _set(self, v): self.ask()
speed = property(_get, _set)
""",
    ),
    "property_call_get": Idiom(
        "x = self.speed",
        methods="""
def _get(self): return self.ask()
speed = property(_get)
""",
    ),
    "property_deleter": Idiom(
        "del self.speed",
        methods="""
@property
def speed(self):
    return 1
@speed.deleter
def speed(self):
    self.ask()
""",
    ),
    "delattr_dunder": Idiom(
        "del self.w.n",
        init="self.w = W(self)",
        before="""
class W:
    def __init__(self, n): self.n = n
    def __delattr__(self, k): self.n.ask()
""",
    ),
    "getattribute": Idiom(
        "x = self.d.foo",
        init="self.d = D(self)",
        before="""
class D:
    def __init__(self, n): object.__setattr__(self, 'n', n)
    def __getattribute__(self, k):
        n = object.__getattribute__(self, 'n')
        n.ask()
        return 1
""",
    ),
    "vars_self": Idiom("vars(self)['f']()", init="self.f = self.ask"),
    "dict_self": Idiom("self.__dict__['f']()", init="self.f = self.ask"),
    "dict_update_self": Idiom(
        "self.h.f()",
        init="self.h = H(f=self.ask)",
        before="""
class H:
    def __init__(self, **kw): self.__dict__.update(kw)
""",
    ),
    "staticmethod_wrapped": Idiom(
        "self.go2(self)",
        methods="""
def go(n): n.ask()
go2 = staticmethod(go)
""",
    ),
    "classmethod_wrapped": Idiom(
        "self.go2(self)",
        methods="""
def go(cls, n): n.ask()
go2 = classmethod(go)
""",
    ),
    "getattr_default": Idiom("getattr(self, 'nope', self.ask)()"),
    "method_func": Idiom("self.ask.__func__(self)"),
    "method_dunder_call": Idiom("self.ask.__call__()"),
    "wrapped_attr": Idiom(
        "Robot.work.__wrapped__(self)",
        methods="""
@deco
def work(self): self.ask()
""",
        before="""
import functools
def deco(f):
    @functools.wraps(f)
    def inner(self): return None
    return inner
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
