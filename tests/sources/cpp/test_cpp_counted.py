"""How often C++ code does something: loops by number, calls of one routine, pointers, limits of steps."""

from pathlib import Path

import pytest

from dineros.sources.cpp import programs
from dineros.sources.cpp.following import machine
from dineros.sources.facts import Entity, Facts, is_open
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

NODE = """
#include <rclcpp/rclcpp.hpp>
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
%s
  }
%s
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
"""


def _facts(folder: Path, body: str, members: str = "") -> Facts:
    (folder / "robot.cpp").write_text(NODE % (body, members), encoding="utf-8")
    return read_source(folder)


def _of(folder: Path, body: str, members: str = "") -> list[Entity]:
    return [each for node in _facts(folder, body, members).nodes for each in node.entities]


@pytest.mark.parametrize(
    ("loop", "names"),
    [
        ("for (int i = 0; i < 3; ++i) { OUT }", ["wheel0", "wheel1", "wheel2"]),
        ("for (int i = 1; i <= COUNT; i++) { OUT }", ["wheel1", "wheel2"]),
        ("for (int i = 1; i != count_; i += 1) { make(i); }", ["wheel1", "wheel2", "wheel3"]),
    ],
)
def test_a_loop_by_a_constant_makes_a_port_in_each_turn(tmp_path: Path, loop: str, names: list[str]) -> None:
    out = 'outs_.push_back(create_publisher<std_msgs::msg::String>("wheel" + std::to_string(i), 1));'
    members = f"static constexpr int COUNT = 2;\n  const int count_ = 4;\n  void make(int i) {{ {out} }}"
    found = _of(tmp_path, loop.replace("OUT", out), members)
    assert [(each.name, each.details.get("instances")) for each in found] == [(name, None) for name in names]


def test_a_loop_by_a_constant_that_publishes_is_a_loop(tmp_path: Path) -> None:
    body = """
    out_ = create_publisher<std_msgs::msg::String>("out", 1);
    create_wall_timer(1s, [this]() { for (int i = 0; i < 3; ++i) { out_->publish(text_); } });
"""
    (facts,) = _facts(tmp_path, body).nodes
    (effect,) = [one for each in facts.callbacks if each.kind == "timer" for one in each.effects]
    assert effect.when == "in a loop"


@pytest.mark.parametrize(
    ("code", "times"),
    [
        ("say(); say();", ["always", "always"]),
        ('for (const auto & each : {"a", "b", "c"}) { say(); }', ["always"] * 3),
        ("if (on_) { say(); } else { say(); }", ["conditional"]),
        ("if (on_) { say(); say(); } else { say(); }", ["conditional", "conditional"]),
        ("if (on_) { say(); } if (off_) { say(); }", ["conditional", "conditional"]),
        ("say(); say(); say(); say(); say(); say();", ["always", "always", "always", "in a loop"]),
    ],
)
def test_each_call_of_a_routine_publishes(tmp_path: Path, code: str, times: list[str]) -> None:
    """A queue of one message loses what a callback publishes twice; one effect would hide that."""
    body = f"""
    out_ = create_publisher<std_msgs::msg::String>("out", 1);
    create_wall_timer(1s, [this]() {{ {code} }});
"""
    (facts,) = _facts(tmp_path, body, "void say() { out_->publish(text_); }").nodes
    assert [one.when for each in facts.callbacks if each.kind == "timer" for one in each.effects] == times


def test_names_in_loops_are_of_one_turn_only_if_the_loop_makes_them(tmp_path: Path) -> None:
    body = """
    std::string grown = "a";
    for (const auto & each : parts_) {
      std::string name = "get";
      name += "/state";
      grown += "b";
      member_ += "c";
      create_publisher<std_msgs::msg::String>(name, 1);
      create_publisher<std_msgs::msg::String>(grown, 1);
      create_publisher<std_msgs::msg::String>(member_, 1);
    }
"""
    found = _of(tmp_path, body, 'std::string member_ = "m"; std::vector<std::string> parts_;')
    assert [each.name for each in found] == ["get/state", "{grown}b", 'open: member_ += "c"']


def test_a_buffer_has_the_text_that_is_printed_to_it(tmp_path: Path) -> None:
    body = """
    char name[] = "out00";
    snprintf(name, sizeof(name), "out%02d", 7);
    create_publisher<std_msgs::msg::String>(name, 1);
    sprintf(name, "%s/%d", "arm", 3);
    create_publisher<std_msgs::msg::String>(name, 1);
    snprintf(name, sizeof(name), "out%02d", number());
    create_publisher<std_msgs::msg::String>(name, 1);
    snprintf(name, sizeof(name), format_, 1);
    create_publisher<std_msgs::msg::String>(name, 1);
"""
    names = [each.name for each in _of(tmp_path, body)]
    assert names[:2] == ["out07", "arm/3"]
    assert all(is_open(each) or "{" in each for each in names[2:])


def test_the_name_of_a_port_may_be_made_of_that_of_another(tmp_path: Path) -> None:
    body = """
    in_ = create_subscription<std_msgs::msg::String>("scan", 1, [this](std_msgs::msg::String::SharedPtr) {});
    create_publisher<std_msgs::msg::String>(std::string(in_->get_topic_name()) + "/flat", 1);
"""
    assert [each.name for each in _of(tmp_path, body)][-1] == "scan/flat"


def test_a_pointer_to_a_class_is_no_object(tmp_path: Path) -> None:
    """Only the object that is made has ports, and its member is what points to it."""
    members = """
    struct Part {
      explicit Part(rclcpp::Node * node = nullptr, std::string name = "unnamed") {
        out_ = node->create_publisher<std_msgs::msg::String>(name, 1);
      }
      rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
    };
    Part * other_;
    Part * part_ = nullptr;
    rclcpp::Node * self_ = this;
"""
    found = _facts(tmp_path, 'part_ = new Part(this, "part");', members)
    assert [each.name for node in found.nodes for each in node.entities] == ["part"]
    assert not found.unread


HELPERS = """
  void work(int number) { STEPS }
  void make(int number) { STEPS create_publisher<std_msgs::msg::String>("late", 1); }
"""


def test_a_long_program_does_not_follow_again_what_did_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine, "_LONG", 0)
    body = "    work(1);\n" * 20 + "    make(1);\n" * 5
    members = HELPERS.replace("STEPS", "sum_ = sum_ + number; " * 60)
    found = _facts(tmp_path, body, members)
    assert [each.name for each in found.nodes[0].entities] == ["late"] * 5
    assert not found.unread
    later = members.replace("sum_ = sum_ + number;", "auto later = [this]() { make(1); };", 1)
    said = (
        "robot.cpp: the program robot is long: 1 routine that did nothing three times is not followed again, "
        "so ports may be missing"
    )
    assert said in _facts(tmp_path, "    work(1);\n" * 20, later).unread
    monkeypatch.setattr(programs, "MOST_STEPS", 5000)
    monkeypatch.setattr(programs, "_LEAST", 1)
    assert "too large" not in str(_facts(tmp_path, "    work(1);\n" * 20, members).unread)
    monkeypatch.setattr(machine, "_LONG", 10**6)
    assert "too large" in str(_facts(tmp_path, "    work(1);\n" * 20, members).unread)


def test_all_programs_of_a_folder_share_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rest of them gets a small limit each, also when the first ones come from the cache."""
    for number in range(3):
        text = NODE % ("    sum_ = 1;\n" * 100 + '    create_publisher<std_msgs::msg::String>("o", 1);', "")
        (tmp_path / f"p{number}.cpp").write_text(text.replace("robot", f"robot{number}"), encoding="utf-8")
    assert not read_source(tmp_path).unread
    monkeypatch.setattr(programs, "_MOST_OF_ALL", 400)
    monkeypatch.setattr(programs, "_LEAST", 50)
    first, again = (read_source(tmp_path, cache=tmp_path.parent / "kept") for _ in range(2))
    assert [each.partition(":")[0] for each in first.unread if "too large" in each] == ["p1.cpp", "p2.cpp"]
    assert first.to_json() == again.to_json()


@pytest.mark.parametrize(
    ("made", "period"),
    [("this", 1.0), ("this, 0.2", 0.2), ("this, 5", 5.0), ("this, rate_", "open: rate_")],
)
def test_an_updater_of_diagnostics_has_the_period_that_it_is_given(
    tmp_path: Path, made: str, period: float | str
) -> None:
    body = f"updater_ = std::make_shared<diagnostic_updater::Updater>({made});"
    (timer,) = [each for each in _of(tmp_path, body) if each.kind == "timers"]
    assert timer.details["period"] == period


def test_methods_of_known_texts_have_results(tmp_path: Path) -> None:
    members = """
    void make(const std::string & name) {
      if (!name.empty()) { create_publisher<std_msgs::msg::String>(name, 1); }
    }
"""
    body = """
    std::string name = "~/twist";
    create_publisher<std_msgs::msg::String>("/arm/" + name.substr(2), 1);
    create_publisher<std_msgs::msg::String>("/arm/" + name.substr(2, 3), 1);
    create_publisher<std_msgs::msg::String>("/arm/" + name.substr(2, name.size()), 1);
    create_publisher<std_msgs::msg::String>("/arm/" + name.substr(start()), 1);
    make(std::string());
    make("made");
"""
    found = _of(tmp_path, body, members)
    names = [each.name for each in found if each.is_enabled]
    assert [*names[:3], names[-1]] == ["/arm/twist", "/arm/twi", "/arm/twist", "made"]
    assert len(names) == 5 and "{" in names[3]


def test_code_that_is_not_followed_again_may_change_what_it_sets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine, "_LONG", 0)
    members = """
    std::string name_ = "arm";
    std::string other_ = "none";
    std::vector<std::string> parts_;
    void work(const std::string & given) { STEPS count(name_); other_ = given; parts_.push_back(given); }
""".replace("STEPS", "sum_ = sum_ + 1; " * 60)
    body = """
    work("a"); work("b"); work("c"); work("d");
    create_publisher<std_msgs::msg::String>(name_, 1);
    create_publisher<std_msgs::msg::String>(other_, 1);
    for (const auto & each : parts_) { create_publisher<std_msgs::msg::String>(each, 1); }
"""
    known, *rest = [each.name for each in _of(tmp_path, body, members)]
    assert known == "arm"
    assert rest and all(is_open(each) for each in rest[:1] + rest[-1:])
