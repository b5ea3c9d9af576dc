"""Values that optional, variant, any and smart pointers hold in C++, and functions of pointers to members."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.programs.asking_programs import asked_by_timer

pytest.importorskip("tree_sitter_cpp")

IDIOMS: dict[str, dict[str, str]] = {
    "optional_emplace": {
        "before": ("class Robot;\n struct Helper { explicit Helper(Robot * r); void go(); Robot * r_; };"),
        "members": "std::optional<Helper> h_;",
        "tick": "h_.emplace(this).go();",
        "after": "Helper::Helper(Robot * r) : r_(r) {}\n void Helper::go() { r_->ask(); }",
    },
    "optional_emplace_value": {
        "before": ("class Robot;\n struct Helper { explicit Helper(Robot * r); void go(); Robot * r_; };"),
        "members": "std::optional<Helper> h_;",
        "tick": "h_.emplace(this);  h_.value().go();",
        "after": "Helper::Helper(Robot * r) : r_(r) {}\n void Helper::go() { r_->ask(); }",
    },
    "optional_arrow": {
        "before": ("class Robot;\n struct Helper { explicit Helper(Robot * r); void go(); Robot * r_; };"),
        "members": "std::optional<Helper> h_;",
        "init": "h_.emplace(this);",
        "tick": "if (h_) { h_->go(); }",
        "after": "Helper::Helper(Robot * r) : r_(r) {}\n void Helper::go() { r_->ask(); }",
    },
    "optional_client": {
        "members": "std::optional<rclcpp::Client<Trigger>::SharedPtr> c_;",
        "init": "c_.emplace(client_);",
        "tick": "c_.value()->async_send_request(std::make_shared<Trigger::Request>()).get();",
    },
    "visit_lambda": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_ = Left{this};",
        "tick": "std::visit([](auto & h) { h.go(); }, h_);",
        "after": "void Left::go() { r->ask(); }",
    },
    "visit_emplace": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_.emplace<Left>(Left{this});",
        "tick": "std::visit([](auto && h) { h.go(); }, h_);",
        "after": "void Left::go() { r->ask(); }",
    },
    "visit_emplace2": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_.emplace<Left>(this);",
        "tick": "std::visit([](auto && h) { h.go(); }, h_);",
        "after": "void Left::go() { r->ask(); }",
    },
    "visit_overloaded": {
        "before": (
            "class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() "
            "{} };\n template<class... Ts> struct overloaded : Ts... { using "
            "Ts::operator()...; };\n template<class... Ts> overloaded(Ts...) -> "
            "overloaded<Ts...>;"
        ),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_ = Left{this};",
        "tick": "std::visit(overloaded{[](Right &) {}, [](Left & l) { l.go(); }}, h_);",
        "after": "void Left::go() { r->ask(); }",
    },
    "visit_functor": {
        "before": (
            "class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() "
            "{} };\n struct Visitor { void operator()(Right & r) { r.go(); } void "
            "operator()(Left & l) { l.go(); } };"
        ),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_ = Left{this};",
        "tick": "std::visit(Visitor{}, h_);",
        "after": "void Left::go() { r->ask(); }",
    },
    "get_if": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_ = Left{this};",
        "tick": "if (auto * l = std::get_if<Left>(&h_)) { l->go(); }",
        "after": "void Left::go() { r->ask(); }",
    },
    "get_type": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::variant<Right, Left> h_;",
        "init": "h_ = Left{this};",
        "tick": "if (std::holds_alternative<Left>(h_)) { std::get<Left>(h_).go(); }",
        "after": "void Left::go() { r->ask(); }",
    },
    "any_cast": {
        "before": ("class Robot;\n struct Left { Robot * r; void go(); };\n struct Right { void go() {} };"),
        "members": "std::any h_;",
        "init": "h_ = Left{this};",
        "tick": "std::any_cast<Left &>(h_).go();",
        "after": "void Left::go() { r->ask(); }",
    },
    "variant_of_functions": {
        "members": "std::variant<std::monostate, std::function<void()>> h_;",
        "init": "h_ = std::function<void()>([this]() { ask(); });",
        "tick": "std::get<std::function<void()>>(h_)();",
    },
    "handle_arrow": {
        "before": "class Robot;\n struct Handle { Robot * r; Robot * operator->() { return r; } };",
        "members": "Handle h_{this};",
        "tick": "h_->ask();",
    },
    "handle_star": {
        "before": "class Robot;\n struct Handle { Robot * r; Robot & operator*() { return *r; } };",
        "members": "Handle h_{this};",
        "tick": "(*h_).ask();",
    },
    "exchange_fn": {
        "members": "std::function<void()> f_;",
        "init": "f_ = [this]() { ask(); };",
        "tick": "auto f = std::exchange(f_, nullptr); if (f) { f(); }",
    },
    "swap_fn": {
        "members": "std::vector<std::function<void()>> q_;",
        "init": "q_.push_back([this]() { ask(); });",
        "tick": ("std::vector<std::function<void()>> now; now.swap(q_); for (auto & f : now) { f(); }"),
    },
    "swap_fn2": {
        "members": "std::vector<std::function<void()>> q_;",
        "init": "q_.push_back([this]() { ask(); });",
        "tick": ("std::vector<std::function<void()>> now; std::swap(now, q_); for (auto & f : now) { f(); }"),
    },
    "optional_fn2": {
        "members": "std::optional<std::function<void()>> f_;",
        "init": "f_.emplace([this]() { ask(); });",
        "tick": "f_.value()();",
    },
    "map_at": {
        "members": "std::map<std::string, rclcpp::Client<Trigger>::SharedPtr> cs_;",
        "init": 'cs_ = {{"a", client_}};',
        "tick": 'cs_.at("a")->async_send_request(std::make_shared<Trigger::Request>()).get();',
    },
    "map_sub": {
        "members": "std::map<std::string, rclcpp::Client<Trigger>::SharedPtr> cs_;",
        "init": 'cs_ = {{"a", client_}};',
        "tick": 'cs_["a"]->async_send_request(std::make_shared<Trigger::Request>()).get();',
    },
    "struct_map": {
        "before": "struct Entry { std::string name; rclcpp::Client<Trigger>::SharedPtr c; };",
        "members": "std::map<int, Entry> cs_;",
        "init": "cs_[3].c = client_;",
        "tick": (
            "for (auto & [k, e] : cs_) { "
            "e.c->async_send_request(std::make_shared<Trigger::Request>()).get(); }"
        ),
    },
    "structured_struct": {
        "before": "struct Both { int n; rclcpp::Client<Trigger>::SharedPtr c; };",
        "members": "Both both() { return Both{1, client_}; }",
        "tick": ("auto [n, c] = both(); c->async_send_request(std::make_shared<Trigger::Request>()).get();"),
    },
    "tie": {
        "members": ("std::pair<int, rclcpp::Client<Trigger>::SharedPtr> both() { return {1, client_}; }"),
        "tick": (
            "int n; rclcpp::Client<Trigger>::SharedPtr c; std::tie(n, c) = both(); "
            "c->async_send_request(std::make_shared<Trigger::Request>()).get();"
        ),
    },
    "function_map": {
        "members": "std::unordered_map<std::string, std::function<void()>> table_;",
        "init": 'table_ = {{"ask", [this]() { ask(); }}};',
        "tick": 'table_.at("ask")();',
    },
    "static_table_struct": {
        "members": "struct Row { const char * name; void (Robot::*step)(); };",
        "tick": (
            'static const Row table[] = {{"ask", &Robot::ask}}; for (const auto & row : '
            "table) { (this->*row.step)(); }"
        ),
    },
    "singleton_ptr": {
        "before": (
            "class Robot;\n class Hub { public: static std::shared_ptr<Hub> get() { if "
            "(!hub_) { hub_ = std::make_shared<Hub>(); } return hub_; } void set(Robot * r) "
            "{ r_ = r; } void go(); private: static std::shared_ptr<Hub> hub_; Robot * r_ = "
            "nullptr; };"
        ),
        "init": "Hub::get()->set(this);",
        "tick": "Hub::get()->go();",
        "after": "std::shared_ptr<Hub> Hub::hub_ = nullptr;\n void Hub::go() { r_->ask(); }",
    },
    "singleton_inline": {
        "before": (
            "class Robot;\n class Hub { public: static inline Hub * hub = nullptr; static "
            "Hub * get() { if (hub == nullptr) { hub = new Hub(); } return hub; } void "
            "set(Robot * r) { r_ = r; } void go(); Robot * r_; };"
        ),
        "init": "Hub::get()->set(this);",
        "tick": "Hub::get()->go();",
        "after": "void Hub::go() { r_->ask(); }",
    },
}
"""Parts of programs, by the way in which `tick` calls `ask`."""


@pytest.mark.parametrize("name", IDIOMS)
def test_the_timer_asks_and_waits(tmp_path: Path, name: str) -> None:
    assert len(asked_by_timer(tmp_path, IDIOMS[name])) == 1
