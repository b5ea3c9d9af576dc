"""What runs at the begin and the end of a ``with``, also through ``contextlib``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "exitstack_callback": Idiom("""
with contextlib.ExitStack() as st:
    st.callback(self.ask)
"""),
    "exitstack_push": Idiom(
        """
with contextlib.ExitStack() as st:
    st.push(self.ask3)
""",
        methods="""
def ask3(self, *a):
    self.ask()
""",
    ),
    "exitstack_popall": Idiom("""
st = contextlib.ExitStack()
st.callback(self.ask)
st.close()
"""),
    "exitstack_enter_cm": Idiom(
        """
with contextlib.ExitStack() as st:
    st.enter_context(asking(self))
""",
        before="""
@contextlib.contextmanager
def asking(n):
    n.ask()
    yield
""",
    ),
    "exitstack_enter_cm_exit": Idiom(
        """
with contextlib.ExitStack() as st:
    st.enter_context(asking(self))
""",
        before="""
@contextlib.contextmanager
def asking(n):
    yield
    n.ask()
""",
    ),
    "exitstack_enter_class": Idiom(
        """
with contextlib.ExitStack() as st:
    st.enter_context(CM(self))
""",
        before="""
class CM:
    def __init__(self, n): self.n = n
    def __enter__(self): return self
    def __exit__(self, *a): self.n.ask()
""",
    ),
    "closing": Idiom(
        """
with contextlib.closing(Dev(self)):
    pass
""",
        before="""
class Dev:
    def __init__(self, n): self.n = n
    def close(self): self.n.ask()
""",
    ),
    "contextmanager": Idiom(
        """
with asking(self):
    pass
""",
        before="""
@contextlib.contextmanager
def asking(n):
    try:
        yield n
    finally:
        n.ask()
""",
    ),
    "contextmanager_as_decorator": Idiom(
        "self.work()",
        init="NODE.append(self)",
        methods="""
@CM()
def work(self):
    pass
""",
        before="""
class CM(contextlib.ContextDecorator):
    def __init__(self): pass
    def __enter__(self): NODE[0].ask()
    def __exit__(self, *a): pass
NODE = []
""",
    ),
    "with_tuple": Idiom(
        """
with (CM(self) as a, CM(self) as b):
    pass
""",
        before="""
class CM:
    def __init__(self, n): self.n = n
    def __enter__(self): self.n.ask()
    def __exit__(self, *a): pass
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
