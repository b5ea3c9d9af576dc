"""Code in C++ that runs without a call by name: destructors, deleters, operators, handlers of exceptions."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.programs.asking_programs import asked_by_timer

pytest.importorskip("tree_sitter_cpp")

IDIOMS: dict[str, dict[str, str]] = {
    "raii_auto": {
        "before": (
            "class Robot;\n struct Guard { explicit Guard(Robot * r) : r_(r) {} ~Guard(); Robot * r_; };"
        ),
        "tick": "auto g = Guard(this);",
        "after": "Guard::~Guard() { r_->ask(); }",
    },
    "raii_unique": {
        "before": (
            "class Robot;\n struct Guard { explicit Guard(Robot * r) : r_(r) {} ~Guard(); Robot * r_; };"
        ),
        "tick": "auto g = std::make_unique<Guard>(this);",
        "after": "Guard::~Guard() { r_->ask(); }",
    },
    "raii_reset": {
        "before": (
            "class Robot;\n struct Guard { explicit Guard(Robot * r) : r_(r) {} ~Guard(); Robot * r_; };"
        ),
        "members": "std::unique_ptr<Guard> g_;",
        "init": "g_ = std::make_unique<Guard>(this);",
        "tick": "g_.reset();",
        "after": "Guard::~Guard() { r_->ask(); }",
    },
    "raii_template": {
        "before": (
            "template<class F> struct ScopeExit { F f; explicit ScopeExit(F g) : "
            "f(std::move(g)) {} ~ScopeExit() { f(); } };"
        ),
        "tick": "ScopeExit e([this]() { ask(); });",
    },
    "raii_rcpputils": {
        "tick": "auto e = rcpputils::make_scope_exit([this]() { ask(); });",
    },
    "temp_dtor": {
        "before": (
            "class Robot;\n struct Guard { explicit Guard(Robot * r) : r_(r) {} ~Guard(); Robot * r_; };"
        ),
        "tick": "Guard(this);",
        "after": "Guard::~Guard() { r_->ask(); }",
    },
    "unique_deleter": {
        "tick": ("std::unique_ptr<int, std::function<void(int *)>> p(new int(1), [this](int *) { ask(); });"),
    },
    "op_plus_eq": {
        "before": "class Robot;\n struct Op { Robot * r; Op & operator+=(int); };",
        "members": "Op o_{this};",
        "tick": "o_ += 3;",
        "after": "Op & Op::operator+=(int) { r->ask(); return *this; }",
    },
    "op_pre_inc": {
        "before": "class Robot;\n struct Op { Robot * r; Op & operator++(); };",
        "members": "Op o_{this};",
        "tick": "++o_;",
        "after": "Op & Op::operator++() { r->ask(); return *this; }",
    },
    "op_not": {
        "before": "class Robot;\n struct Op { Robot * r; bool operator!(); };",
        "members": "Op o_{this};",
        "tick": "if (!o_) { return; }",
        "after": "bool Op::operator!() { r->ask(); return false; }",
    },
    "op_bool": {
        "before": "class Robot;\n struct Op { Robot * r; explicit operator bool(); };",
        "members": "Op o_{this};",
        "tick": "if (o_) { return; }",
        "after": "Op::operator bool() { r->ask(); return false; }",
    },
    "op_eq_assign": {
        "before": "class Robot;\n struct Op { Robot * r; Op & operator=(int); };",
        "members": "Op o_{this};",
        "tick": "o_ = 3;",
        "after": "Op & Op::operator=(int) { r->ask(); return *this; }",
    },
    "in_catch": {
        "tick": 'try { throw std::runtime_error("x"); } catch (...) { ask(); }',
    },
}
"""Parts of programs, by the way in which `tick` calls `ask`."""


@pytest.mark.parametrize("name", IDIOMS)
def test_the_timer_asks_and_waits(tmp_path: Path, name: str) -> None:
    assert len(asked_by_timer(tmp_path, IDIOMS[name])) == 1
