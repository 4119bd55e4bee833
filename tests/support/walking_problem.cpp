#include "tests/support/walking_problem.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/integrators/zero_order_hold.hpp"

namespace saltus::testing_support {
namespace {

struct LegDrivenCart {  // x = (position, speed), u = forces of the left and the right leg
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], u[0] + u[1]};
  }
};

}  // namespace

Schedule walking_schedule() {
  return Schedule({"left", "double", "right"}, {{"touch", 0.35}, {"goal", 0.62}})
      .declare({"flight"})
      .reserve(walk_capacity);
}

MultipleShooting walking_problem(const Schedule& schedule, bool with_change_costs) {
  const auto phase = [&](const char* name, double duration) {
    const auto position = [](const auto&, const auto& x) { return x[0]; };
    const auto speed = [](const auto&, const auto& x) { return x[1]; };
    const auto all = [](const auto&, const auto& x) { return x; };
    const auto forces = [](const auto&, const auto&, const auto& u) { return u; };
    const auto work = [](const auto&, const auto& x, const auto& u) { return x[1] + u[0] - u[1]; };
    Phase<2, 2> walk{name, LegDrivenCart{}, exactly(duration)};
    walk.bound_input(0, exactly(0.0), during("right", "flight"))
        .bound_input(0, between(-1.0, 3.0), during("left", "double"))
        .bound_input(1, exactly(0.0), during("left", "flight"))
        .bound_input(1, between(-3.0, 1.0), during("double", "right"))
        .track("forces", forces, Vec<double, 2>{0.2, 0.3})
        .track("rest", all, Vec<double, 2>{4.0, 1.0})
        .track("slow", speed, Vec<double, 1>{3.0}, during("double"))
        .keep("lane", position, between(-0.4, 0.4), during("flight"), soft("lane", 20.0))
        .keep("power", work, at_most(1.0), during("left", "right"), soft("power", 5.0, Penalty::L2))
        .keep("late", speed, at_most(0.5), Window{.from = event("goal")}, soft("late", 2.0));
    if (with_change_costs) walk.penalise_change(Vec<double, 2>{0.05, 0.05});
    return walk;
  };
  OptimalControlProblem ocp("walk");
  ocp.schedule(schedule).start_at({0.8, 0.4}).then(phase("near", 0.6)).then(phase("far", 0.4));
  return {std::move(ocp), {.intervals = {6, 4}, .integrator = zero_order_hold()}};
}

std::string edit_at_random(Schedule& schedule, double now, std::mt19937& random) {
  const auto below = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  double time = now + uniform(-0.2, walk_horizon + 0.3);
  if (below(3) == 0) time = std::round(10.0 * time) / 10.0;  // at a node, or nearly
  if (below(6) == 0) time += uniform(-1.5, 1.5) * same_instant;
  const std::string mode = schedule.known_modes()[below(4)];
  const int events = static_cast<int>(schedule.events().size());
  const int chosen = below(events);
  const std::string event = schedule.events()[chosen].name.str();
  switch (below(8)) {
    case 0:
    case 1: {
      if (events == schedule.capacity()) return "nothing";
      std::string name;
      for (int i = 0; name.empty() || schedule.contains(name); ++i)
        name = "event " + std::to_string(i);
      schedule.insert(mode, name, time);
      return "insert " + mode;
    }
    case 2:
      if (event == "goal") return "nothing";
      schedule.erase(event);
      return "erase " + event;
    case 3:
      schedule.replace(event, mode);
      return "replace " + event + " by " + mode;
    case 4:
      schedule.replace_first(mode);
      return "begin with " + mode;
    case 5:
      schedule.confirm(event, time);
      return "confirm " + event;
    case 6:
      schedule.hold(event, now, 0.1);
      return "hold " + event;
    default: {
      if (chosen > 0) time = std::max(time, schedule.events()[chosen - 1].time);
      if (chosen + 1 < events) time = std::min(time, schedule.events()[chosen + 1].time);
      schedule.retime(event, time);
      return "retime " + event;
    }
  }
}

}  // namespace saltus::testing_support
