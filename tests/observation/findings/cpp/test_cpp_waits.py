"""Callbacks in C++ that wait for what only blocked callbacks can do, as developers write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source
from tests.support.programs.coded import run

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using Fibonacci = example_interfaces::action::Fibonacci;
using std_msgs::msg::String;
using std_srvs::srv::Trigger;
using Goal = rclcpp_action::ServerGoalHandle<Fibonacci>;
struct Device { std::string name; rclcpp::Client<Trigger>::SharedPtr client; };
struct Shared { bool done = false; };
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, IS_ADDED);
    rclcpp::SubscriptionOptions options;
    options.callback_group = GROUP;
    sub_ = create_subscription<String>("in", 1, [this](String::SharedPtr) { HEARS }, options);
    client_ = create_client<Trigger>("ask", rclcpp::ServicesQoS(), GROUP);
    actions_ = rclcpp_action::create_client<Fibonacci>(this, "go", GROUP);
    timer_ = create_wall_timer(1s, [this]() { tick(); });
    MORE
  }
  void ask() { client_->async_send_request(std::make_shared<Trigger::Request>()).get(); }
  void tick() { TICK }
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Subscription<String>::SharedPtr sub_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp_action::Client<Fibonacci>::SharedPtr actions_;
  rclcpp_action::Server<Fibonacci>::SharedPtr server_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::executors::SingleThreadedExecutor executor_;
  std::vector<Device> devices_;
  std::thread thread_;
  std::future<void> kept_;
  std::once_flag once_;
  std::atomic<bool> done_{false};
  State state_ = State::IDLE;
  Shared shared_;
  std::mutex mutex_;
  int left_ = 0;
  bool is_done() { std::lock_guard<std::mutex> lock(mutex_); return done_; }
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  EXECUTOR
}
"""
MULTI = """
  rclcpp::executors::MultiThreadedExecutor executor;
  executor.add_node(std::make_shared<Robot>());
  executor.spin();
"""
SINGLE = "rclcpp::spin(std::make_shared<Robot>());"


def written(folder: Path, tick: str = "", executor: str = MULTI, **words: str) -> Path:
    """Write the robot, and return its folder."""
    text = ROBOT.replace("TICK", tick).replace("EXECUTOR", executor)
    for word, usual in (("IS_ADDED", "true"), ("GROUP", "nullptr"), ("HEARS", ""), ("MORE", "")):
        text = text.replace(word, words.get(word.lower(), usual))
    (folder / "robot.cpp").write_text(text)
    return folder


def waits(folder: Path) -> bool:
    """Return whether a callback waits for what cannot happen meanwhile."""
    found = code_findings([(".", read_source(folder))])
    return any(each.rule == "code-waits-for-itself" for each in found)


def calls(folder: Path) -> bool:
    """Return whether the timer's callback waits for a response."""
    (node,) = read_source(folder).nodes
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    return any(each.do == "call" and each.how.startswith("blocks") for each in tick.effects)


SLEEPS = "std::this_thread::sleep_for(10ms);"
RESETS = f"done_ = false; while (rclcpp::ok() && !done_) {{ {SLEEPS} }}"


@pytest.mark.parametrize("group", ["nullptr", "group_"])
@pytest.mark.parametrize(
    ("hears", "tick"),
    [
        ("done_ = true;", RESETS),
        ("done_ = true;", f"done_ = false; do {{ {SLEEPS} }} while (!done_);"),
        ("done_ = true;", f"done_ = false; while (rclcpp::ok()) {{ if (done_) {{ break; }} {SLEEPS} }}"),
        ("done_ = true;", f"done_ = false; for (; !done_.load();) {{ {SLEEPS} }}"),
        (
            "state_ = State::DONE;",
            f"state_ = State::BUSY; while (state_ != State::DONE) {{ if (!rclcpp::ok()) return; {SLEEPS} }}",
        ),
        ("shared_.done = true;", f"shared_.done = false; while (!shared_.done) {{ {SLEEPS} }}"),
        ("--left_;", f"left_ = 3; while (left_ > 0) {{ {SLEEPS} }}"),
        ("done_ = true;", f"done_ = false; while (!is_done()) {{ {SLEEPS} }}"),
    ],
)
def test_loops_wait_for_members_that_they_have_reset(
    tmp_path: Path, hears: str, tick: str, group: str
) -> None:
    """That a callback itself resets the member before does not end its loop: "0 found" before."""
    assert waits(written(tmp_path, tick, hears=hears, group=group)) == (group == "nullptr")


@pytest.mark.parametrize(
    ("hears", "tick"),
    [
        ("done_ = false;", f"done_ = true; while (!done_) {{ {SLEEPS} }}"),
        ("done_ = true;", f"while (rclcpp::ok()) {{ if (done_) {{ break; }} if (late()) break; {SLEEPS} }}"),
        ("done_ = true;", f"for (int i = 0; i < 9 && !done_; ++i) {{ {SLEEPS} }}"),
    ],
)
def test_loops_that_end(tmp_path: Path, hears: str, tick: str) -> None:
    assert not waits(written(tmp_path, tick, hears=hears))


@pytest.mark.parametrize(
    ("tick", "hears", "is_found"),
    [
        # An atomic with a memory order, and texts.
        (
            "done_ = false; while (!done_.load(std::memory_order_acquire)) { rclcpp::sleep_for(5ms); }",
            "done_.store(true, std::memory_order_release);",
            True,
        ),
        ('while (rclcpp::ok()) { if (text_ == "idle") { break; } rclcpp::sleep_for(5ms); }', "HEARD", True),
        ('text_.clear(); while (text_ != "idle") { rclcpp::sleep_for(5ms); }', "HEARD", True),
        ('text_ = "idle"; while (text_ != "idle") { rclcpp::sleep_for(5ms); }', "HEARD", False),
        # The loop does more than to wait; other variables change.
        (
            "while (!done_) { int turns = 0; turns++; left_ = 3; pub_->publish(std_msgs::msg::Empty()); }",
            "SETS",
            True,
        ),
        ("while (!done_) { count_spin_turns(); rclcpp::sleep_for(5ms); }", "SETS", True),
        ("while (!done_) { auto text = std::make_shared<String>(); text->data.append(1); }", "SETS", True),
        # Several members, a distance, and a request to cancel the goal.
        ("while (!done_ || left_ < 2) { rclcpp::sleep_for(5ms); }", "SETS left_ = 1;", True),
        (
            "const int old = left_; while (std::abs(left_ - old) < 5) { rclcpp::sleep_for(5ms); }",
            "left_++;",
            True,
        ),
        ("while (!done_) { if (goal->is_canceling()) { return; } rclcpp::sleep_for(5ms); }", "SETS", True),
        # It ends by time, or by a count.
        (
            "const auto end = now() + 1s; while (!done_ && now() < end) { rclcpp::sleep_for(5ms); }",
            "SETS",
            False,
        ),
        ("int i = 0; while (!done_ && i < 9) { i++; rclcpp::sleep_for(5ms); }", "SETS", False),
        ("int i = 0; while (!done_) { if (++i > 9) { break; } rclcpp::sleep_for(5ms); }", "SETS", False),
        ("while (left_ < 9) { left_++; rclcpp::sleep_for(5ms); }", "left_ = 0;", False),
        ("while (!done_) { if (rand() > 9) { break; } rclcpp::sleep_for(5ms); }", "SETS", False),
        # It changes what it waits for, or runs callbacks, perhaps in a method.
        ("auto self = shared_from_this(); while (!done_) { self->finish(); }", "SETS", False),
        ("while (!done_) { finish(); }", "SETS", False),
        ("while (!done_) { turn(); }", "SETS", False),
        ("while (!done_) { executor_.spin_some(); }", "SETS", False),
        ("while (!done_) { spinOnce(); }", "SETS", False),
    ],
)
def test_what_a_loop_does_besides_waiting(tmp_path: Path, tick: str, hears: str, is_found: bool) -> None:
    hears = hears.replace("SETS", "done_ = true;").replace("HEARD", "text_ = msg->data;")
    more = """}
      void finish() { done_ = true; }
      void turn() { executor_.spin_some(); }
      void count_spin_turns() { left_++; }
      std::string text_;
      rclcpp::Publisher<String>::SharedPtr pub_;
      void unused() {"""
    written(tmp_path, tick, SINGLE, hears=hears, more=more)
    assert waits(tmp_path) is is_found


@pytest.mark.parametrize("group", ["nullptr", "group_"])
@pytest.mark.parametrize(
    "tick",
    [
        """std::promise<void> done; auto future = done.get_future();
        client_->async_send_request(std::make_shared<Trigger::Request>(),
          [&done](rclcpp::Client<Trigger>::SharedFuture) { done.set_value(); });
        future.wait();""",
        f"""auto goal = Fibonacci::Goal(); goal.order = 3; done_ = false;
        auto options = rclcpp_action::Client<Fibonacci>::SendGoalOptions();
        options.result_callback = [this](const auto &) {{ done_ = true; }};
        actions_->async_send_goal(goal, options); {RESETS}""",
        f"""auto options = rclcpp_action::Client<Fibonacci>::SendGoalOptions();
        options.feedback_callback = [this](auto, auto) {{ done_ = true; }};
        actions_->async_send_goal(Fibonacci::Goal(), options); {RESETS}""",
    ],
)
def test_callbacks_of_responses_set_what_is_waited_for(tmp_path: Path, tick: str, group: str) -> None:
    """Goals whose fields are set lost their callbacks, and feedback had none."""
    assert waits(written(tmp_path, tick, group=group)) == (group == "nullptr")


def test_a_future_that_an_executor_has_spun_for_is_ready(tmp_path: Path) -> None:
    """As map_saver of nav2: a callback makes a subscription, and an executor that runs only this."""
    tick = """std::promise<void> done; auto future = done.get_future();
      auto group = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, false);
      rclcpp::SubscriptionOptions options; options.callback_group = group;
      auto sub = create_subscription<String>("map", 1, [&done](String::SharedPtr) { done.set_value(); },
        options);
      rclcpp::executors::SingleThreadedExecutor executor;
      executor.add_callback_group(group, get_node_base_interface());
      auto status = executor.spin_until_future_complete(future, limit_);
      if (status != rclcpp::FutureReturnCode::SUCCESS) { return; }
      future.get();"""
    assert not waits(written(tmp_path, tick, SINGLE))


def test_a_promise_that_was_asked_with_a_time_out_is_set(tmp_path: Path) -> None:
    """The first wait is in vain, and only a warning: the second one is reached only if it was not."""
    tick = """std::promise<void> done; auto future = done.get_future();
      client_->async_send_request(std::make_shared<Trigger::Request>(),
        [&done](rclcpp::Client<Trigger>::SharedFuture) { done.set_value(); });
      if (future.wait_for(2s) == std::future_status::ready) { future.get(); }"""
    found = code_findings([(".", read_source(written(tmp_path, tick)))])
    assert [(each.severity, each.rule) for each in found] == [("warning", "code-waits-for-itself")]


@pytest.mark.parametrize(
    ("tick", "hangs"),
    [
        ("auto job = std::async(std::launch::async, [this]() { ask(); }); job.get();", True),
        ("std::async(std::launch::async, &Robot::ask, this);", True),
        ("auto job = std::async([this]() { ask(); }); done_ = true;", True),
        ("auto job = std::async([this]() { ask(); }); kept_ = std::move(job);", False),
        (
            "kept_ = std::async([this]() { ask(); }); "
            "while (kept_.wait_for(1ms) != std::future_status::ready) { rclcpp::sleep_for(1ms); }",
            True,
        ),
        (
            "kept_ = std::async([this]() { ask(); }); "
            "if (kept_.wait_for(0s) == std::future_status::ready) { kept_.get(); }",
            False,
        ),
        ("std::thread worker([this]() { ask(); }); worker.join();", True),
        ("std::thread worker([this]() { ask(); }); worker.detach();", False),
        ("std::jthread worker([this]() { ask(); });", True),
        ("std::vector<std::thread> all; all.emplace_back([this]() { ask(); }); all.back().join();", True),
        ("std::call_once(once_, [this]() { ask(); });", True),
        ("std::for_each(devices_.begin(), devices_.end(), [this](auto &) { ask(); });", True),
    ],
)
def test_callbacks_wait_for_the_end_of_what_they_start(tmp_path: Path, tick: str, hangs: bool) -> None:
    """The destructor of the future of ``std::async``, and of ``std::jthread``, waits."""
    assert calls(written(tmp_path, tick)) == hangs


def test_a_thread_that_is_waited_for_does_nothing_at_another_time(tmp_path: Path) -> None:
    """Its requests at any time made the response get lost for which the callback waits."""
    tick = "auto job = std::async([this]() { ask(); }); job.get();"
    (node,) = read_source(written(tmp_path, tick)).nodes
    assert "thread" not in {each.kind for each in node.callbacks}


@pytest.mark.long
@pytest.mark.parametrize(
    ("more", "hangs"),
    [
        ("", True),
        ("thread_ = std::thread([this]() { executor_.spin(); });", False),
        ("node_thread_ = std::make_unique<nav2_util::NodeThread>(executor_);", False),
    ],
)
def test_groups_that_another_executor_runs(tmp_path: Path, more: str, hangs: bool) -> None:
    adds = "executor_.add_callback_group(group_, get_node_base_interface());" if more else ""
    is_added = "false" if more else "true"
    written(tmp_path, "ask();", SINGLE, group="group_", is_added=is_added, more=adds + more)
    _, shown = run("check", "-q", "--source", tmp_path)
    assert ("[callback-deadlock]" in shown) == hangs, shown


def test_other_groups_still_share_the_only_thread(tmp_path: Path) -> None:
    """The thread of one group does not run others: the poller and the subscription need the same one."""
    more = (
        "other_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, false);"
        "executor_.add_callback_group(other_, get_node_base_interface());"
        "thread_ = std::thread([this]() { executor_.spin(); });"
    )
    assert waits(written(tmp_path, RESETS, SINGLE, hears="done_ = true;", group="group_", more=more))


@pytest.mark.parametrize(
    ("starts", "hangs"),
    [("execute(goal);", True), ("std::thread([this, goal]() { execute(goal); }).detach();", False)],
)
def test_work_on_a_goal_that_only_a_cancellation_ends(tmp_path: Path, starts: str, hangs: bool) -> None:
    more = f"""server_ = rclcpp_action::create_server<Fibonacci>(this, "fib",
      [](auto, auto) {{ return rclcpp_action::GoalResponse::ACCEPT_AND_EXECUTE; }},
      [](auto) {{ return rclcpp_action::CancelResponse::ACCEPT; }},
      [this](std::shared_ptr<Goal> goal) {{ {starts} }});
  }}
  void execute(std::shared_ptr<Goal> goal) {{ while (!goal->is_canceling()) {{ count_ += 1; {SLEEPS} }}"""
    assert waits(written(tmp_path, more=more)) == hangs


def test_objects_in_braces_have_their_members(tmp_path: Path) -> None:
    tick = "for (auto & each : devices_) { each.client->async_send_request(request()).get(); }"
    assert calls(written(tmp_path, tick, more='devices_.push_back({"laser", client_});'))


@pytest.mark.parametrize(("limit", "is_found"), [("", True), (", 500ms", False)])
def test_the_next_message_of_a_topic_may_never_come(tmp_path: Path, limit: str, is_found: bool) -> None:
    tick = f'String out; rclcpp::wait_for_message<String>(out, shared_from_this(), "image"{limit});'
    found = code_findings([(".", read_source(written(tmp_path, tick)))])
    assert any("for a message of image: forever" in each.message for each in found) == is_found


SERVERS = [
    ("while not C.wait_for_service(1.0): pass", "while (!C->wait_for_service(1s)) {}", True),
    ("C.wait_for_service()", "C->wait_for_service(std::chrono::nanoseconds(-1));", True),
    (
        "while not C.wait_for_service(1.0):\n            if not rclpy.ok(): return",
        "while (!C->wait_for_service(1s)) { if (!rclcpp::ok()) { return; } }",
        True,
    ),
    (
        "while not C.wait_for_service(1.0) and rclpy.ok(): pass",
        "while (!C->wait_for_service(1s) && rclcpp::ok()) {}",
        True,
    ),
    (
        "while True:\n            if C.wait_for_service(1.0): break",
        "while (true) { if (C->wait_for_service(1s)) { break; } }",
        True,
    ),
    (
        "while rclpy.ok():\n            if C.wait_for_service(1.0): return",
        "while (rclcpp::ok()) { if (C->wait_for_service(1s)) return; }",
        True,
    ),
    ("while not C.wait_for_service(1.0): return", "while (!C->wait_for_service(1s)) { return; }", False),
    (
        "while self.left > 0 and not C.wait_for_service(1.0): self.left -= 1",
        "while (left_ > 0 && !C->wait_for_service(1s)) { --left_; }",
        False,
    ),
    (
        "while self.left > 0:\n            if C.wait_for_service(1.0): break\n            self.left -= 1",
        "while (left_ > 0) { if (C->wait_for_service(1s)) break; --left_; }",
        False,
    ),
    ("if not C.wait_for_service(1.0): return", "if (!C->wait_for_service(1s)) { return; }", False),
]
PYTHON = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.client = self.create_client(Trigger, "ask")
        self.left = 3
        self.create_timer(1.0, self.tick)
    def tick(self):
        TICK
rclpy.init()
rclpy.spin(Robot())
"""


@pytest.mark.parametrize(("python", "cpp", "is_endless"), SERVERS)
def test_both_languages_report_the_same_waits_for_services(
    tmp_path: Path, python: str, cpp: str, is_endless: bool
) -> None:
    for language in ("python", "cpp"):
        folder = tmp_path / language
        folder.mkdir()
        if language == "cpp":
            written(folder, cpp.replace("C->", "client_->"))
        else:
            (folder / "robot.py").write_text(PYTHON.replace("TICK", python.replace("C.", "self.client.")))
        found = [each.rule for each in code_findings([(".", read_source(folder))])]
        assert ("code-waits" in found) == is_endless, (language, found)


GLOBALS = """
#include <rclcpp/rclcpp.hpp>
rclcpp::Node::SharedPtr g_node;
static rclcpp::Client<std_srvs::srv::Trigger>::SharedPtr g_client = nullptr;
void on_text(const std_msgs::msg::String::SharedPtr) {
  auto future = g_client->async_send_request(std::make_shared<std_srvs::srv::Trigger::Request>());
  WAITS
}
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  g_node = rclcpp::Node::make_shared("global");
  g_client = g_node->create_client<std_srvs::srv::Trigger>("act");
  auto sub = g_node->create_subscription<std_msgs::msg::String>("text", 10, on_text);
  rclcpp::spin(g_node);
}
"""


@pytest.mark.parametrize(
    ("awaits", "done"),
    [
        ("future.get();", [("call", "blocks, without time-out")]),
        (
            "rclcpp::spin_until_future_complete(g_node, future);",
            [("call", "spin-until-future-complete, without time-out")],
        ),
        ("rclcpp::spin_some(g_node);", [("call", "async"), ("spin", "without end")]),
    ],
)
def test_global_variables_hold_nodes_and_clients(
    tmp_path: Path, awaits: str, done: list[tuple[str, str]]
) -> None:
    """Ports of a node in a global variable were "not read"."""
    (tmp_path / "robot.cpp").write_text(GLOBALS.replace("WAITS", awaits))
    facts = read_source(tmp_path)
    (node,) = facts.nodes
    assert not facts.unread
    assert [(each.do, each.how) for one in node.callbacks for each in one.effects] == done
