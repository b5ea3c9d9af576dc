"""Nodes in C++: what their code says, and what it leaves open."""

from pathlib import Path
from textwrap import dedent

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
class Robot : public rclcpp::Node {
 public:
  explicit Robot(const rclcpp::NodeOptions & options) : Node("robot", options), rate_(4) {
    declare_parameter("topic", "scan");
    group_ = create_callback_group(rclcpp::CallbackGroupType::Reentrant);
    pub_ = create_publisher<std_msgs::msg::String>(
      get_parameter("topic").as_string() + "/out", rclcpp::QoS(7).transient_local());
    client_ = create_client<std_srvs::srv::Trigger>("reset");
    timer_ = create_wall_timer(
      std::chrono::milliseconds(1000 / rate_), std::bind(&Robot::tick, this), group_);
    sub_ = create_subscription<std_msgs::msg::String>("in", rclcpp::SensorDataQoS(),
      [this](std_msgs::msg::String::SharedPtr msg) { if (msg) { pub_->publish(*msg); } });
  }
 private:
  void tick() { help(); auto answer = client_->async_send_request(request_); answer.wait(); }
  void help() { rclcpp::sleep_for(2s); }
  int rate_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 3);
  auto node = std::make_shared<Robot>(rclcpp::NodeOptions());
  executor.add_node(node);
  executor.spin();
}
"""


def _read(folder: Path, text: str) -> Facts:
    (folder / "robot.cpp").write_text(dedent(text))
    return read_source(folder)


def test_a_node_has_its_ports_timers_and_threads(tmp_path: Path) -> None:
    (node,) = [each.to_json() for each in _read(tmp_path, ROBOT).nodes]
    assert (node["name"], node["threads"]) == ("robot", 3)
    (pub,), (sub,), (timer,) = node["publishers"], node["subscriptions"], node["timers"]
    assert (pub["name"], pub["type"], pub["depth"]) == ("scan/out", "std_msgs/msg/String", 7)
    assert (pub["durability"], sub["reliability"]) == ("transient_local", "best_effort")
    assert (timer["period"], timer["callback"], timer["group"]) == (0.25, "tick", "group_")


def test_effects_are_found_through_helpers(tmp_path: Path) -> None:
    (node,) = [each.to_json() for each in _read(tmp_path, ROBOT).nodes]
    effects = {each["name"]: each["effects"] for each in node["callbacks"]}
    assert [each["do"] for each in effects["tick"]] == ["sleep", "call"]
    assert effects["tick"][1]["how"] == "blocks, without time-out"
    assert [(each["do"], each["when"]) for each in effects["lambda"]] == [("publish", "conditional")]


def test_a_name_that_is_not_known_is_open(tmp_path: Path) -> None:
    text = ROBOT.replace('get_parameter("topic").as_string()', "from_elsewhere()")
    (node,) = [each.to_json() for each in _read(tmp_path, text).nodes]
    assert "{" in node["publishers"][0]["name"] or node["publishers"][0]["name"].startswith("open")


def test_a_managed_node_makes_its_ports_in_transitions(tmp_path: Path) -> None:
    text = """
    class Managed : public rclcpp_lifecycle::LifecycleNode {
     public:
      Managed() : LifecycleNode("managed") {}
      CallbackReturn on_configure(const rclcpp_lifecycle::State &) {
        pub_ = create_publisher<std_msgs::msg::String>("out", 10);
        return CallbackReturn::SUCCESS;
      }
      CallbackReturn on_activate(const rclcpp_lifecycle::State &) { pub_->publish(message_); }
    };
    """
    (node,) = _read(tmp_path, text).nodes
    assert node.managed and [each.name for each in node.of("publishers")] == ["out"]
    assert [each.do for fact in node.callbacks for each in fact.effects] == ["create", "publish"]


def test_each_turn_of_a_loop_makes_a_port(tmp_path: Path) -> None:
    loop = """
      std::vector<std::string> names{"a", "b"};
      for (auto & name : names) { all_.push_back(create_client<std_srvs::srv::Trigger>(name)); }
    """
    first = 'declare_parameter("topic", "scan");'
    (node,) = _read(tmp_path, ROBOT.replace(first, first + loop)).nodes
    assert [each.name for each in node.of("clients")] == ["a", "b", "reset"]


@pytest.mark.parametrize("text", ["(" * 100_000, "int main() { " + "-" * 5000 + "1; }"])
def test_hostile_code_ends(tmp_path: Path, text: str) -> None:
    assert _read(tmp_path, text).nodes == []


HELPERS = """
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot"), camera_{this, "image", std::bind(&Robot::seen, this, _1, _2), "raw"} {
    driver_ = std::make_unique<vendor::Driver>(this, 7);
    limits_ = std::make_shared<vendor::ParamListener>(get_node_parameters_interface());
    states_.push_back(new Battery(this));
    states_.push_back(new Imu(this));
    timer_ = create_wall_timer(100ms, [this]() { for (const auto & each : states_) each->publish(now()); });
  }
  void seen(const Image::ConstSharedPtr & image, const CameraInfo::ConstSharedPtr & info) {
    std::thread{std::bind(&Robot::work, this)}.detach();
    if (!image) throw std::runtime_error("no image");
    timer_.reset();
  }
  void work() { rclcpp::sleep_for(2s); }
  image_transport::CameraSubscriber camera_;
  std::list<Sensor *> states_;
  std::unique_ptr<vendor::Driver> driver_;
  std::shared_ptr<vendor::ParamListener> limits_;
  rclcpp::TimerBase::SharedPtr timer_;
};
"""
STATES = """
#include <power_msgs/msg/battery_state.hpp>
using namespace power_msgs::msg;
class Battery : public Sensor {
 public:
  Battery(rclcpp::Node * node) { pub_ = node->create_publisher<BatteryState>("battery", 10); }
  void publish(const rclcpp::Time & now) override { pub_->publish(message_); }
  rclcpp::Publisher<BatteryState>::SharedPtr pub_;
};
class Imu : public Sensor {
 public:
  Imu(rclcpp::Node * node) { pub_ = node->create_publisher<sensor_msgs::msg::Imu>("imu", 10); }
  void publish(const rclcpp::Time & now) override { pub_->publish(message_); }
  rclcpp::Publisher<sensor_msgs::msg::Imu>::SharedPtr pub_;
};
"""


def test_helpers_in_a_list_of_pointers_publish(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, STATES + HELPERS).nodes
    timer = next(fact for fact in node.callbacks if fact.kind == "timer")
    entities = [each.entity for each in timer.effects if each.do == "publish"]
    assert [each.name for each in entities if each is not None] == ["battery", "imu"]


def test_a_name_without_a_namespace_is_that_of_the_header(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, STATES + HELPERS).nodes
    assert [each.type for each in node.of("publishers")] == [
        "power_msgs/msg/BatteryState",
        "sensor_msgs/msg/Imu",
    ]


def test_code_that_is_not_there_and_gets_the_node_is_named(tmp_path: Path) -> None:
    """What only reads parameters is not."""
    facts = _read(tmp_path, STATES + HELPERS)
    (line,) = [each for each in facts.unread if "receives the node" in each]
    assert "vendor::Driver receives the node, but its code is not in the folder" in line


def test_a_camera_is_heard_and_its_callback_read(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, STATES + HELPERS).nodes
    heard, info = node.of("subscriptions")
    assert info.type == "sensor_msgs/msg/CameraInfo"
    assert (heard.name, heard.type) == ("image", "sensor_msgs/msg/Image")
    seen = next(fact for fact in node.callbacks if fact.name == "seen")
    assert [each.do for each in seen.effects] == ["thread", "throw", "destroy"]


SYNCHRONIZED = """
class Fusion : public rclcpp::Node {
 public:
  Fusion() : Node("fusion"), left_(this, "left"), right_(this, "right", rmw_qos_profile_sensor_data) {
    both_ = std::make_shared<message_filters::TimeSynchronizer<Image, Image>>(left_, right_, 10);
    both_->registerCallback(std::bind(&Fusion::merged, this, _1, _2));
    out_ = create_publisher<sensor_msgs::msg::Image>("out", 1);
  }
  void merged(const Image::ConstSharedPtr & left, const Image::ConstSharedPtr &) { out_->publish(left); }
  message_filters::Subscriber<sensor_msgs::msg::Image> left_;
  message_filters::Subscriber<sensor_msgs::msg::Image> right_;
};
"""


def test_a_synchronizer_has_one_callback_for_its_inputs(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, SYNCHRONIZED).nodes
    left, right = node.of("subscriptions")
    assert {each.callbacks["callback"].name for each in (left, right)} == {"merged"}
    assert (left.details["depth"], left.details["reliability"]) == (10, "reliable")
    assert (right.details["depth"], right.details["reliability"]) == (5, "best_effort")


SUBSCRIBED_LATER = """
class Fusion : public rclcpp::Node {
  using Policy = message_filters::sync_policies::ApproximateTime<Image, Image>;
 public:
  Fusion() : Node("fusion"), both_(Policy(10), left_, right_) {
    left_.subscribe(this, "left");
    right_.subscribe(this, "right");
    both_.registerCallback(std::bind(&Fusion::merged, this, _1, _2));
  }
  void merged(const Image::ConstSharedPtr & left, const Image::ConstSharedPtr &) {}
  message_filters::Subscriber<sensor_msgs::msg::Image> left_, right_;
  message_filters::Synchronizer<Policy> both_;
};
"""


def test_inputs_of_a_synchronizer_subscribe_after_it_was_made(tmp_path: Path) -> None:
    """The callback was missing."""
    (node,) = _read(tmp_path, SUBSCRIBED_LATER).nodes
    assert {each.callbacks["callback"].name for each in node.of("subscriptions")} == {"merged"}


PLANNER = """
class Planner : public nav2_util::LifecycleNode {
  using Compute = example_interfaces::action::Fibonacci;
  using ActionServer = nav2_util::SimpleActionServer<Compute>;
 public:
  Planner() : nav2_util::LifecycleNode("planner", "") {}
  nav2_util::CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
    plans_ = create_publisher<sensor_msgs::msg::Image>("plan", 1);
    server_ = std::make_unique<ActionServer>(
        shared_from_this(), "compute", std::bind(&Planner::compute, this));
    return nav2_util::CallbackReturn::SUCCESS;
  }
  void compute() {
    if (server_->is_cancel_requested()) { server_->terminate_all(); return; }
    plans_->publish(sensor_msgs::msg::Image());
    server_->succeeded_current();
  }
  std::unique_ptr<ActionServer> server_;
};
"""


def test_the_action_server_of_nav2_works_on_a_thread_of_its_own(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, PLANNER).nodes
    (server,) = node.of("action_servers")
    assert (server.name, server.type) == ("compute", "example_interfaces/action/Fibonacci")
    work = server.callbacks["execute"]
    assert (work.kind, work.is_apart) == ("execute", True)
    assert [each.do for each in work.effects] == ["canceled", "publish", "succeed"]


THREADED = """
void script(std::shared_ptr<Asker> asker) { asker->ask(); }
int main() {
  auto asker = std::make_shared<Asker>();
  auto done = std::async(std::launch::async, script, asker);
  rclcpp::spin(asker);
}
"""
ASKER = """
class Asker : public rclcpp::Node {
 public:
  Asker() : Node("asker") { client_ = create_client<std_srvs::srv::Empty>("reset"); }
  void ask() { client_->wait_for_service(); client_->async_send_request(request_); }
  rclcpp::Client<std_srvs::srv::Empty>::SharedPtr client_;
};
"""


def test_a_thread_of_the_main_function_belongs_to_the_node_that_it_uses(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, ASKER + THREADED).nodes
    (thread,) = [fact for fact in node.callbacks if fact.kind == "thread"]
    assert [each.do for each in thread.effects] == ["wait_for_service", "call"]


CHANGES = """
class Turn {
 public:
  Turn(rclcpp_action::Client<Dock>::SharedPtr client) : client_(client) {}
  void begin() {
    auto options = rclcpp_action::Client<Dock>::SendGoalOptions();
    options.goal_response_callback = [this](const GoalHandle & handle) { is_ready_ = true; };
    client_->async_send_goal(goal_, options);
  }
  void end() { if (is_ready_) client_->async_cancel_goal(handle_); }
  bool is_ready_{false};
  rclcpp_action::Client<Dock>::SharedPtr client_;
};
class Docker : public rclcpp::Node {
 public:
  Docker() : Node("docker") {
    client_ = rclcpp_action::create_client<nav::action::Dock>(this, "dock");
    timer_ = create_wall_timer(1s, std::bind(&Docker::tick, this));
  }
  void tick() { turn_ = std::make_shared<Turn>(client_); turn_->begin(); turn_->end(); }
  std::shared_ptr<Turn> turn_;
};
"""


def test_what_an_answer_gives_to_a_member_counts_in_other_methods(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, CHANGES).nodes
    tick = next(fact for fact in node.callbacks if fact.kind == "timer")
    assert [each.do for each in tick.effects] == ["send_goal", "cancel_goal"]


PLAIN_CALLS = """
class Helper {
 public:
  Helper(rclcpp::Node::SharedPtr node) { pub_ = node->create_publisher<std_msgs::msg::String>("help", 1); }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr pub_;
};
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    auto period = nav2::declare_or_get_parameter(this, "period", 0.5);
    helper_ = std::make_unique<Helper>(shared_from_this());
    timer_ = create_wall_timer(std::chrono::duration<double>(period), []() {});
    srv_ = create_service<std_srvs::srv::Empty>(std::string(get_name()) + "/reset", [](auto, auto) {});
  }
};
"""


def test_a_node_is_what_its_own_methods_return(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, PLAIN_CALLS).nodes
    assert [each.name for each in node.of("publishers")] == ["help"]
    assert [each.name for each in node.of("services")] == ["robot/reset"]
    assert [each.details["period"] for each in node.of("timers")] == [0.5]


SYSTEM = """
struct Times {
  using milliseconds = std::chrono::milliseconds;
  static constexpr std::chrono::nanoseconds LIDAR = milliseconds(100);
};
struct Connection { std::string input; std::string output; };
struct Settings { std::string name; std::chrono::nanoseconds cycle; std::vector<Connection> connections; };
class Worker : public rclcpp::Node {
 public:
  explicit Worker(const Settings & settings) : Node(settings.name) {
    timer_ = create_wall_timer(settings.cycle, [this]() {});
    for (const auto & each : settings.connections) {
      subs_.push_back(create_subscription<std_msgs::msg::String>(each.input, 1, [](auto) {}));
      pubs_.push_back(create_publisher<std_msgs::msg::String>(each.output, 1));
    }
  }
};
template <typename Timing>
std::vector<std::shared_ptr<rclcpp::Node>> make_nodes() {
  std::vector<std::shared_ptr<rclcpp::Node>> nodes;
  nodes.emplace_back(std::make_shared<Worker>(
    Settings{.name = "worker", .cycle = Timing::LIDAR, .connections = {{"a", "b"}, {"c", "d"}}}));
  return nodes;
}
"""
HIDDEN_MAIN = """
int main() {
  using Chosen = Times;
  auto nodes = make_nodes<Chosen>();
  somewhere.run(nodes);
}
"""
SPINNING_MAIN = """
int main() {
  using Chosen = Times;
  auto nodes = make_nodes<Chosen>();
  rclcpp::executors::SingleThreadedExecutor executor;
  for (auto & node : nodes) { executor.add_node(node); }
  executor.spin();
}
"""


def test_constants_of_a_chosen_class_and_items_of_a_list(tmp_path: Path) -> None:
    (node,) = _read(tmp_path, SYSTEM + SPINNING_MAIN).nodes
    assert [each.details["period"] for each in node.of("timers")] == [0.1]
    assert [each.name for each in node.of("subscriptions")] == ["a", "c"]
    assert [each.name for each in node.of("publishers")] == ["b", "d"]


def test_of_two_programs_the_one_counts_whose_executor_is_known(tmp_path: Path) -> None:
    (tmp_path / "worker.hpp").write_text(SYSTEM)
    (tmp_path / "a_hidden.cpp").write_text('#include "worker.hpp"' + HIDDEN_MAIN)
    (tmp_path / "b_spinning.cpp").write_text('#include "worker.hpp"' + SPINNING_MAIN)
    (node,) = read_source(tmp_path).nodes
    assert (node.program, node.executor, node.threads) == ("b_spinning", "SingleThreadedExecutor", 1)
    assert node.also_in == ["a_hidden"]


WORKS_APART = """
class Cleaner : public rclcpp::Node {
 public:
  Cleaner() : Node("cleaner") {
    client_ = create_client<std_srvs::srv::Trigger>("ready");
    server_ = rclcpp_action::create_server<nav::action::Clean>(this, "clean", &goal, &cancel,
      std::bind(&Cleaner::accepted, this, _1));
  }
  void accepted(const std::shared_ptr<GoalHandle> handle) {
    std::thread{std::bind(&Cleaner::execute, this, _1), handle}.detach();
  }
  void execute(const std::shared_ptr<GoalHandle> handle) {
    auto answer = client_->async_send_request(request_);
    answer.wait();
    handle->succeed(result_);
  }
};
"""


def test_work_on_a_goal_in_its_own_thread_that_waits_forever_is_found(tmp_path: Path) -> None:
    facts = _read(tmp_path, WORKS_APART)
    (finding,) = code_findings([("src", facts)])
    assert finding.rule == "code-waits" and "without a response, the goal never ends" in finding.message
    assert "execute" in finding.message and finding.lines == ("src/robot.cpp:13",)


def test_a_class_may_have_the_name_of_its_base(tmp_path: Path) -> None:
    """``rclcpp::Node("door")`` is the base of ``sup::Node``, and no other constructor of it."""
    facts = _read(
        tmp_path,
        """
        #include <rclcpp/rclcpp.hpp>
        namespace sup {
        class Node : public rclcpp::Node {
         public:
          Node() : Node(7) {}
          explicit Node(int depth);
        };
        Node::Node(int depth) : rclcpp::Node("door") {
          pub_ = create_publisher<std_msgs::msg::String>("x", depth);
        }
        }
        int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<sup::Node>()); }
        """,
    )
    (node,) = facts.nodes
    (pub,) = node.to_json()["publishers"]
    assert (node.name, pub["name"], pub["depth"], facts.unread) == ("door", "x", 7, [])


def test_events_of_parameters_are_heard_with_a_static_method(tmp_path: Path) -> None:
    (tmp_path / "robot.cpp").write_text("""
#include "rclcpp/rclcpp.hpp"
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    out_ = create_publisher<std_msgs::msg::String>("out", 1);
    heard_ = rclcpp::AsyncParametersClient::on_parameter_event(
      this->get_node_topics_interface(), std::bind(&Robot::onEvent, this, std::placeholders::_1));
  }
 private:
  void onEvent(const rcl_interfaces::msg::ParameterEvent::SharedPtr) {
    out_->publish(std_msgs::msg::String());
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
  rclcpp::Subscription<rcl_interfaces::msg::ParameterEvent>::SharedPtr heard_;
};
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
""")
    (node,) = read_source(tmp_path).nodes
    (heard,) = node.of("subscriptions")
    assert (heard.name, heard.type) == ("/parameter_events", "rcl_interfaces/msg/ParameterEvent")
    assert [each.do for each in heard.callbacks["callback"].effects] == ["publish"]
