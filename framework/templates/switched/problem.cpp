#include "problem.hpp"

#include <saltus/ocp/phase.hpp>

using namespace saltus;

namespace {

struct Sledge {     // x = (position m, speed m/s), u = pull per mass, m/s^2
  double friction;  // coefficient of the ground; valid for forward motion only

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 9.81 * friction - 0.02 * x[1] * x[1]};
  }
};

}  // namespace

OptimalControlProblem make_problem(double friction_of_gravel) {
  const auto clock = [](auto t, auto) { return t; };
  const auto pull = [](auto, auto, auto u) { return u[0]; };
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto onto_gravel = [](auto, auto x) { return x[0] - gravel_begins; };

  Phase<2, 1> ice{"ice", Sledge{0.02}, between(0.5, 20.0)};
  ice.bound_input(0, between(0.0, 4.0))
      .track("effort", pull, VectorXd::Constant(1, 0.1))
      .ends_when("onto gravel", onto_gravel, Crossing::rising)
      .guess_duration(4.0);
  Phase<2, 1> gravel{"gravel", Sledge{friction_of_gravel}, between(0.1, 20.0)};
  gravel.bound_input(0, between(0.0, 4.0))
      .track("effort", pull, VectorXd::Constant(1, 0.1))
      .reach("finish", position, exactly(finish))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock)
      .guess_duration(3.0);

  OptimalControlProblem problem("sledge");
  problem.start_at({0.0, 0.0}).then(ice).then(gravel);
  return problem;
}
