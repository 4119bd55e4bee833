#include "problems/library/motion.hpp"

#include "saltus/simulation/plants.hpp"

namespace saltus::library {

Motion simulate_motion(const IntervalProblem& problem, const IntegratorChoice& scheme,
                       const VectorXd& x0, const VectorXd& times, const VectorXd& p) {
  Motion motion;
  motion.integrator = scheme->name();
  Recording& recording = motion.recording;
  IntegratorPlant plant(problem, scheme, x0, p, times[0]);
  const VectorXd none = VectorXd::Zero(problem.arguments.nu);
  const auto add = [&](double t, const VectorXd& x, const std::string& mode) {
    recording.samples.push_back({t, x, none, mode});
  };
  add(times[0], x0, plant.mode());
  for (Eigen::Index k = 1; k < times.size(); ++k) {
    const bool moved = plant.advance(none, times[k] - plant.time());
    for (HybridEvent& event : plant.take_events()) {
      add(event.time, event.before, event.mode_before);
      add(event.time, event.after, event.mode_after);
      recording.events.push_back(std::move(event));
    }
    if (!moved) {
      motion.failure = plant.failure();
      break;
    }
    add(plant.time(), plant.state(), plant.mode());
  }
  return motion;
}

}  // namespace saltus::library
