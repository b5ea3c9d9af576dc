"""Functions that C++ code calls through pointers to members, tasks, templates and ``std``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.programs.asking_programs import asked_by_timer

pytest.importorskip("tree_sitter_cpp")

IDIOMS: dict[str, dict[str, str]] = {
    "memptr_map_at": {
        "members": "std::map<std::string, void (Robot::*)()> steps_;",
        "init": 'steps_.emplace("ask", &Robot::ask);',
        "tick": '(this->*(steps_.at("ask")))();',
    },
    "memptr_map_find": {
        "members": 'std::map<std::string, void (Robot::*)()> steps_{{"ask", &Robot::ask}};',
        "tick": ('auto it = steps_.find("ask"); if (it != steps_.end()) { (this->*(it->second))(); }'),
    },
    "memptr_alias": {
        "members": "using Step = void (Robot::*)(); std::map<int, Step> steps_;  int state_ = 1;",
        "init": "steps_ = {{1, &Robot::ask}};",
        "tick": "auto f = steps_[state_]; (this->*f)();",
    },
    "memptr_obj": {
        "members": "void (Robot::*step_)() = &Robot::ask;",
        "tick": "Robot * self = this; (self->*step_)();",
    },
    "memptr_ref": {
        "members": "void (Robot::*step_)() = &Robot::ask;",
        "tick": "Robot & self = *this; (self.*step_)();",
    },
    "invoke": {
        "members": "void (Robot::*step_)() = &Robot::ask;",
        "tick": "std::invoke(step_, this);",
    },
    "invoke2": {
        "tick": "std::invoke(&Robot::ask, this);",
    },
    "mem_fn": {
        "tick": "auto f = std::mem_fn(&Robot::ask); f(this);",
    },
    "mem_fn2": {
        "tick": "std::mem_fn(&Robot::ask)(*this);",
    },
    "call_once2": {
        "members": "std::once_flag once_;",
        "tick": "std::call_once(once_, &Robot::ask, this);",
    },
    "free_function_ptr": {
        "before": "class Robot;\n void go(Robot * robot);",
        "members": "void (*f_)(Robot *) = &go;",
        "tick": "f_(this);",
        "after": "void go(Robot * robot) { robot->ask(); }",
    },
    "packaged_task": {
        "tick": "std::packaged_task<void()> task([this]() { ask(); }); task();",
    },
    "packaged_task_thread": {
        "tick": (
            "std::packaged_task<void()> task([this]() { ask(); }); auto f = "
            "task.get_future(); std::thread t(std::move(task)); f.get(); t.join();"
        ),
    },
    "policy_base": {
        "before": (
            "template<class P> struct Host : public P { template<class R> void run(R * r) { "
            "this->go(r); } };\n struct Asks { template<class R> void go(R * r) { r->ask(); "
            "} };"
        ),
        "members": "Host<Asks> host_;",
        "tick": "host_.run(this);",
    },
    "ranges_for_each": {
        "members": "std::vector<rclcpp::Client<Trigger>::SharedPtr> cs_;",
        "init": "cs_.push_back(client_);",
        "tick": (
            "std::ranges::for_each(cs_, [](auto & c) { "
            "c->async_send_request(std::make_shared<Trigger::Request>()).get(); });"
        ),
    },
    "not_fn": {
        "members": "bool one() { ask(); return true; }",
        "tick": "auto f = std::not_fn(std::bind(&Robot::one, this)); f();",
    },
    "fn_template_ptr": {
        "members": "template<void (Robot::*F)()> void call() { (this->*F)(); }",
        "tick": "call<&Robot::ask>();",
    },
    "fn_class_template": {
        "before": (
            "template<class T, void (T::*F)()> struct Del { T * t; void operator()() { (t->*F)(); } };"
        ),
        "tick": "Del<Robot, &Robot::ask> d{this}; d();",
    },
    "variadic": {
        "members": (
            "template<class F, class... A> void run(F f, A... a) { f(a...); } static void "
            "two(Robot * r) { r->ask(); }"
        ),
        "tick": "run(&Robot::two, this);",
    },
    "variadic_fwd": {
        "members": (
            "template<class F, class... A> auto run(F && f, A &&... a) { return "
            "std::invoke(std::forward<F>(f), std::forward<A>(a)...); }"
        ),
        "tick": "run(&Robot::ask, this);",
    },
    "fold": {
        "members": "template<class... F> void all(F... f) { (f(), ...); }",
        "tick": "all([this]() { ask(); });",
    },
    "friend_fn": {
        "members": "friend void go(Robot & r) { r.ask(); }",
        "tick": "go(*this);",
    },
    "local_struct": {
        "tick": "struct Doer { Robot * r; void go() { r->ask(); } }; Doer d{this}; d.go();",
    },
    "local_struct_op": {
        "tick": ("struct Doer { Robot * r; void operator()() const { r->ask(); } }; Doer d{this}; d();"),
    },
    "signals2": {
        "members": "boost::signals2::signal<void()> sig_;",
        "init": "sig_.connect([this]() { ask(); });",
        "tick": "sig_();",
    },
    "signals2_bind": {
        "members": "boost::signals2::signal<void(int)> sig_;",
        "init": "sig_.connect(std::bind(&Robot::ask, this));",
        "tick": "sig_(3);",
    },
    "operator_outside": {
        "before": "class Robot; struct Asks { Robot * robot; }; void operator<<(Asks & asks, int);",
        "members": "Asks asks_{this};",
        "tick": "asks_ << 3;",
        "after": "void operator<<(Asks & asks, int) { asks.robot->ask(); }",
    },
    "if_constexpr": {
        "before": "template<bool B, class R> void go(R * r) { if constexpr (B) { r->ask(); } }",
        "tick": "go<true>(this);",
    },
}
"""Parts of programs, by the way in which `tick` calls `ask`."""


@pytest.mark.parametrize("name", IDIOMS)
def test_the_timer_asks_and_waits(tmp_path: Path, name: str) -> None:
    assert len(asked_by_timer(tmp_path, IDIOMS[name])) == 1
