/* Does what two nodes of rclcpp do, as far as ros2_tracing sees it: the events are those of its tp_call.h, in the
   order in which rclcpp has them. ABOUT.md says how the trace beside is made of it. */

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/prctl.h>
#include <unistd.h>

#define TRACEPOINT_CREATE_PROBES
#define TRACEPOINT_DEFINE
#include "tracetools/tp_call.h"

#define A(n) ((const void *)(uintptr_t)(0x561200000000ULL + (n)))
#define T(...) tracepoint(ros2, __VA_ARGS__)

enum { DRIVER = 0x100, MAPPER = 0x200, SCAN = 0x310, MAP = 0x410, LOG = 0x420, SPEED = 0x510, SLOW = 0x520,
       ASKED = 0x530, HEALTH = 0x610, TICK = 0x330, ON_SCAN = 0x430, ON_ODOM = 0x540, NAP = 0x550, WHERE = 0x730 };

static void node(int handle, const char *name) { T(rcl_node_init, A(handle), A(handle + 1), name, "/"); }
static void publisher(int handle, int node, const char *topic) {
  T(rcl_publisher_init, A(handle), A(node), A(handle + 1), topic, 10);
}
static void subscription(int callback, int node, const char *topic) {
  int handle = callback + 0x1000;
  T(rcl_subscription_init, A(handle), A(node), A(handle + 1), topic, 10);
  T(rclcpp_subscription_init, A(handle), A(handle + 2));
  T(rclcpp_subscription_callback_added, A(handle + 2), A(callback));
  T(rclcpp_callback_register, A(callback), "void (Mapper::*)(std::shared_ptr<std_msgs::msg::String const>)");
}
static void timer(int callback, int node, int64_t period, const char *symbol) {
  int handle = callback + 0x1000;
  T(rcl_timer_init, A(handle), period);
  T(rclcpp_timer_callback_added, A(handle), A(callback));
  T(rclcpp_callback_register, A(callback), symbol);
  T(rclcpp_timer_link_node, A(handle), A(node));
}
static void publish(int handle, bool within) {
  if (within) T(rclcpp_intra_publish, A(handle), A(0x9000));
  T(rclcpp_publish, A(0x9000));
  T(rcl_publish, A(handle), A(0x9000));
  T(rmw_publish, A(handle + 1), A(0x9000), 5);
}
static void executor(void) {
  T(rclcpp_executor_wait_for_work, -1);
  T(rclcpp_executor_get_next_ready);
}
static void start(int callback) {
  T(rclcpp_executor_execute, A(callback + 0x1000));
  T(callback_start, A(callback), false);
}
static void end(int callback) { T(callback_end, A(callback)); executor(); }

static void on_odom(void) { start(ON_ODOM); publish(SPEED, false); end(ON_ODOM); }

static void *driver(void *_) {
  for (int i = 0; i < 12; i++) { start(TICK); usleep(300); publish(SCAN, false); end(TICK); usleep(20000); }
  return _;
}
static void *scans(void *_) {
  usleep(1000);
  for (int i = 0; i < 12; i++) {
    start(ON_SCAN); usleep(6000); publish(MAP, false);
    if (i % 3 == 0) publish(LOG, true);
    end(ON_SCAN); usleep(14000);
  }
  return _;
}
static void *others(void *_) {
  usleep(4000); /* while a scan is worked on */
  for (int i = 0; i < 12; i++) {
    on_odom();
    if (i % 2 == 0) { /* spins while it waits for something, and then goes on */
      start(NAP); executor(); on_odom(); publish(SLOW, false); publish(SLOW, false); end(NAP);
    } else { /* answers later: its end is not told, and what comes after it is not of it */
      start(WHERE); publish(ASKED, false); executor(); publish(HEALTH, false);
    }
    usleep(20000);
  }
  return _;
}
static void *outside(void *_) {
  for (int i = 0; i < 3; i++) { usleep(70000); publish(HEALTH, false); }
  return _;
}

int main(void) {
  prctl(PR_SET_NAME, "a \"b\" } = 1,\\");
  sleep(1);
  T(rcl_init, A(1));
  node(DRIVER, "driver");
  publisher(SCAN, DRIVER, "/scan");
  timer(TICK, DRIVER, 20000000, "Driver::tick()");
  node(MAPPER, "mapper");
  publisher(MAP, MAPPER, "/map"); publisher(LOG, MAPPER, "/log"); publisher(SPEED, MAPPER, "/speed");
  publisher(SLOW, MAPPER, "/slow"); publisher(ASKED, MAPPER, "/asked"); publisher(HEALTH, MAPPER, "/health");
  subscription(ON_SCAN, MAPPER, "/scan"); subscription(ON_ODOM, MAPPER, "/odom");
  timer(NAP, MAPPER, 40000000, "Mapper::nap() \"{ callback = 0x1 }\"");
  T(rcl_service_init, A(WHERE + 0x1000), A(MAPPER), A(WHERE + 0x1001), "/where");
  T(rclcpp_service_callback_added, A(WHERE + 0x1000), A(WHERE));
  pthread_t threads[4];
  void *(*run[4])(void *) = {driver, scans, others, outside};
  for (int i = 0; i < 4; i++) pthread_create(&threads[i], 0, run[i], 0);
  for (int i = 0; i < 4; i++) pthread_join(threads[i], 0);
  return 0;
}
