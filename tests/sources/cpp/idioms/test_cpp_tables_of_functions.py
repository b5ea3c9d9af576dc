"""Functions in arrays, lists and members: what their calls do is in the facts."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using Words = std_msgs::msg::String;
BEFORE
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    out_ = create_publisher<Words>("out", 1);
    number_ = std::rand();
    INIT
    timer_ = create_wall_timer(1s, [this]() { tick(); });
  }
  void tick() { TICK }
  void say() { out_->publish(Words()); }
  void none() {}
  rclcpp::Publisher<Words>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
  int number_;
  MEMBERS
};
AFTER
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
"""
STEPS = "{[]() {}, [this]() { say(); }};"
STEP = "struct Step { int n; std::function<void()> run; };"
PAIR = "struct Step { const char * n; void (Robot::*run)(); };"
LOUD = "struct Loud { Robot * r; explicit Loud(Robot * x) : r(x) {} ~Loud() { r->say(); } };"


def when(folder: Path, **parts: str) -> list[str]:
    """Return when the timer publishes, for each place of the code that does it."""
    text = ROBOT
    for each in ("BEFORE", "INIT", "TICK", "MEMBERS", "AFTER"):
        text = text.replace(each, parts.get(each.lower(), ""))
    (folder / "robot.cpp").write_text(text)
    (node,) = read_source(folder).nodes
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    return [each.when for each in tick.effects if each.do == "publish"]


@pytest.mark.parametrize(
    ("tick", "members"),
    [
        ("steps_[1]();", f"std::function<void()> steps_[2] = {STEPS}"),
        ("steps_[1]();", f"std::function<void()> steps_[2]{STEPS}"),
        ("(this->*steps_[1])();", "void (Robot::*steps_[2])() = {&Robot::none, &Robot::say};"),
        ("step_.second();", "std::pair<int, std::function<void()>> step_{1, [this]() { say(); }};"),
    ],
)
def test_the_function_of_a_known_number_is_called(tmp_path: Path, tick: str, members: str) -> None:
    assert when(tmp_path, tick=tick, members=members) == ["always"]


@pytest.mark.parametrize(
    ("tick", "members"),
    [
        ("steps_[number_]();", f"std::function<void()> steps_[2] = {STEPS}"),
        ("steps_[number_]();", f"std::vector<std::function<void()>> steps_ = {STEPS}"),
        ("if (number_ > 2) { steps_[number_](); }", f"std::array<std::function<void()>, 2> steps_ = {STEPS}"),
        ("(this->*steps_[number_])();", "void (Robot::*steps_[2])() = {&Robot::none, &Robot::say};"),
    ],
)
def test_any_function_of_an_unknown_number_may_be_called(tmp_path: Path, tick: str, members: str) -> None:
    assert when(tmp_path, tick=tick, members=members) == ["conditional"]


@pytest.mark.parametrize(
    ("tick", "members"),
    [
        (
            "for (auto & e : steps_) e.run();",
            f"{STEP} std::vector<Step> steps_ = {{{{1, [this]() {{ say(); }}}}}};",
        ),
        (
            "steps_.at(1).run();",
            f"{STEP} std::map<int, Step> steps_ = {{{{1, {{2, [this]() {{ say(); }}}}}}}};",
        ),
        (
            "for (auto & e : table) (this->*e.run)();",
            f'{PAIR} static constexpr Step table[] = {{{{"a", &Robot::say}}}};',
        ),
        (
            "for (auto & e : table) (this->*e.run)();",
            f'{PAIR} static inline const std::vector<Step> table = {{{{"a", &Robot::say}}}};',
        ),
    ],
)
def test_functions_in_objects_in_braces(tmp_path: Path, tick: str, members: str) -> None:
    assert len(when(tmp_path, tick=tick, members=members)) == 1


@pytest.mark.parametrize(
    "tick",
    [
        "Step s; s.run = [this]() { say(); }; s.run();",
        "Step s{1, [this]() { say(); }}; s.run();",
        "Step s{.n = 1, .run = [this]() { say(); }}; s.run();",
    ],
)
def test_functions_in_members_of_local_objects(tmp_path: Path, tick: str) -> None:
    assert len(when(tmp_path, tick=tick, members=STEP)) == 1


def test_a_table_of_functions_outside_of_the_class(tmp_path: Path) -> None:
    before = "class Robot; void none(Robot &); void talk(Robot &);\n"
    before += "struct Step { int n; void (*run)(Robot &); };\n"
    before += "static const Step TABLE[] = {{1, none}, {2, talk}};"
    after = "void none(Robot &) {}\nvoid talk(Robot & r) { r.say(); }"
    found = when(tmp_path, before=before, after=after, tick="for (auto & e : TABLE) e.run(*this);")
    assert len(found) == 1


def test_a_list_that_is_swapped_with_the_waiting_functions(tmp_path: Path) -> None:
    tick = "decltype(steps_) now; now.swap(steps_); for (auto & f : now) f();"
    tick = "steps_.push_back([this]() { say(); });" + tick
    found = when(tmp_path, tick=tick, members="std::vector<std::function<void()>> steps_;")
    assert set(found) == {"in a loop"}


@pytest.mark.parametrize(
    ("tick", "member", "expected"),
    [
        ("auto * loud = new Loud(this); delete loud;", "", "always"),
        ("delete loud_; loud_ = nullptr;", "Loud * loud_ = new Loud(this);", "always"),
        ("loud_ = nullptr;", "std::unique_ptr<Loud> loud_ = std::make_unique<Loud>(this);", "always"),
        ("loud_ = nullptr;", "std::shared_ptr<Loud> loud_ = std::make_shared<Loud>(this);", "conditional"),
        ("loud_.reset();", "std::shared_ptr<Loud> loud_ = std::make_shared<Loud>(this);", "conditional"),
    ],
)
def test_destructors_of_objects_that_are_let_go(
    tmp_path: Path, tick: str, member: str, expected: str
) -> None:
    assert when(tmp_path, tick=tick, members=f"{LOUD} {member}") == [expected]


@pytest.mark.parametrize(
    ("argument", "other", "own"),
    [
        ('std::string("a")', "int", "const std::string &"),
        ('"a"', "double", "const char *"),
        ("1.5", "const std::string &", "double"),
        ("std::vector<int>{}", "int", "const std::vector<int> &"),
        ("[](int) {}", "int", "std::function<void(int)>"),
        ("nullptr", "int", "std::shared_ptr<int>"),
        ("geometry_msgs::msg::Pose()", "int", "const geometry_msgs::msg::Pose &"),
    ],
)
def test_the_constructor_that_fits_is_followed(tmp_path: Path, argument: str, other: str, own: str) -> None:
    made = f"struct Loud {{ Loud(Robot &, {other} o) {{}} Loud(Robot & r, {own} o) {{ r.say(); }} }};"
    assert when(tmp_path, tick=f"Loud loud(*this, {argument});", members=made) == ["always"]
    made = f"struct Loud {{ Loud(Robot & r, {other} o) {{ r.say(); }} Loud(Robot &, {own} o) {{}} }};"
    assert when(tmp_path, tick=f"Loud loud(*this, {argument});", members=made) == []


def test_each_constructor_that_may_fit_is_followed(tmp_path: Path) -> None:
    made = "struct Loud { Loud(Robot &, int o) {} Loud(Robot & r, Other o) { r.say(); } };"
    assert when(tmp_path, tick="Loud loud(*this, unknown());", members=made) == ["conditional"]


@pytest.mark.parametrize(
    ("tick", "members", "before"),
    [
        ("use(steps_);", "lib::Steps steps_ = lib::steps([this]() { say(); });", ""),
        ("use(step_);", "lib::Step step_ = lib::step(&Robot::say);", ""),
        (
            "use(TABLE, *this);",
            "",
            "class Robot; void talk(Robot & r);\nstatic const lib::Table TABLE = {talk};",
        ),
    ],
)
def test_functions_that_values_name_have_a_line(tmp_path: Path, tick: str, members: str, before: str) -> None:
    text = ROBOT.replace("BEFORE", before).replace("TICK", tick).replace("MEMBERS", members)
    after = "void talk(Robot & r) { r.say(); }" if before else ""
    (tmp_path / "robot.cpp").write_text(text.replace("INIT", "").replace("AFTER", after))
    found = read_source(tmp_path)
    does = [each.do for node in found.nodes for one in node.callbacks for each in one.effects]
    assert "publish" in does or any("not followed" in each for each in found.unread)
