#include "tests/support/event_problems.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace saltus::testing_support {

OptimalControlProblem with_impact(const Phase<1, 1>& phase, double impact) {
  OptimalControlProblem ocp("event test");
  ocp.schedule(Schedule({"before", "after"}, {{"impact", impact}})).start_at({1}).then(phase);
  return ocp;
}

std::vector<double> active_times(MultipleShooting& shooting, const std::string& term) {
  std::vector<double> times;
  const NonlinearProgram& nlp = shooting.nlp();
  for (int r = 0; r < nlp.rows(); ++r) {
    const std::string text = nlp.describe_row(r);
    if (text.find("term '" + term + "'") == std::string::npos) continue;
    if (std::isinf(nlp.row_lower()[r]) && std::isinf(nlp.row_upper()[r])) continue;
    times.push_back(std::stod(text.substr(text.find("t = ") + 4)));
  }
  return times;
}

std::vector<InputBounds> input_bounds(MultipleShooting& shooting, int phase) {
  std::vector<InputBounds> result;
  for (int k = 0; k < shooting.grid().intervals(phase); ++k) {
    if (shooting.grid().interval(phase, k).is_empty()) continue;
    const int v = shooting.layout().input(phase, k);
    result.push_back({shooting.grid().node_offset(phase, k),
                      shooting.grid().node_offset(phase, k + 1),
                      {shooting.nlp().lower()[v], shooting.nlp().upper()[v]}});
  }
  return result;
}

double cost_at(MultipleShooting& shooting, double x, double u) {
  NlpPoint point = shooting.initial_guess();
  const Grid& grid = shooting.grid();
  for (int j = 0; j < grid.phases(); ++j)
    for (int k = 0; k <= grid.intervals(j); ++k) {
      point.w[shooting.layout().state(j, k)] = x;
      if (k < grid.intervals(j)) point.w[shooting.layout().input(j, k)] = u;
    }
  double cost = 0.0;
  EXPECT_TRUE(shooting.nlp().objective(point.w.data(), cost));
  return cost;
}

}  // namespace saltus::testing_support
