"""Functions that libraries, errors and collections hand back to the callback, which calls them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "np_vectorize": Idiom(
        """
np.vectorize(self.f)([1])
""",
        methods="""
def f(self, x):
    self.ask()
""",
        before="""
import numpy as np
""",
    ),
    "np_apply": Idiom(
        """
np.apply_along_axis(self.f, 0, [1])
""",
        methods="""
def f(self, x):
    self.ask()
""",
        before="""
import numpy as np
""",
    ),
    "scipy_min": Idiom(
        """
minimize(self.f, [0])
""",
        methods="""
def f(self, x):
    self.ask()
""",
        before="""
from scipy.optimize import minimize
""",
    ),
    "scipy_ivp": Idiom(
        """
solve_ivp(self.f, (0, 1), [0])
""",
        methods="""
def f(self, t, x):
    self.ask()
""",
        before="""
from scipy.integrate import solve_ivp
""",
    ),
    "third_party_retry": Idiom(
        """
tenacity.retry(self.ask)()
""",
        before="""
import tenacity
""",
    ),
    "cprofile_runcall": Idiom(
        """
cProfile.Profile().runcall(self.ask)
""",
        before="""
import cProfile
""",
    ),
    "dict_popitem": Idiom(
        """
self.d.popitem()[1]()
""",
        init="""
self.d = {'a': self.ask}
""",
    ),
    "operator_call": Idiom("""
operator.call(self.ask)
"""),
    "a_long_list": Idiom(
        """
for run in self.runs:
    run()
""",
        init="self.runs = [" + 69 * "self.nothing, " + "self.ask]",
        methods="def nothing(self): pass",
    ),
    "try_exc_carry": Idiom(
        """
try:
    self.find()
except Found as e:
    e.f()
""",
        methods="""
def find(self):
    raise Found(self.ask)
""",
        before="""
class Found(Exception):
    def __init__(self, f): self.f = f
""",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
