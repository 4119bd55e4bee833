// One problem, every solver: a crane moves a load by 2 m in 3 s from rest to rest. All solvers find
// the same optimum.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <saltus/saltus.hpp>
#include <saltus/solver/ipopt.hpp>

using namespace saltus;

struct Crane {  // x = (position of the cart m, angle of the rope rad, their rates), u = force in N
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    constexpr double cart = 1.0, load = 2.0, length = 1.5, g = 9.81;  // kg, kg, m, m/s^2
    const S s = sin(x[1]), c = cos(x[1]);
    const S mass = cart + load * s * s;
    const S spin = load * length * x[3] * x[3] * s;
    return {x[2], x[3], (spin + u[0] + load * g * c * s) / mass,
            -(spin * c + u[0] * c + (cart + load) * g * s) / (length * mass)};
  }
};

int main() {
  const auto state = [](auto, auto x) { return x; };
  const auto force = [](auto, auto, auto u) { return u; };

  Phase<4, 1> move{"move", Crane{}, exactly(3.0)};
  move.bound_input(0, between(-10.0, 10.0))
      .bound_state(1, between(-0.25, 0.25))
      .reach("there, at rest", state, {exactly(2.0), exactly(0.0), exactly(0.0), exactly(0.0)})
      .track("effort", force, VectorXd::Ones(1));
  OptimalControlProblem ocp("crane");
  ocp.start_at({0, 0, 0, 0}).then(move);

  struct Named {
    const char* name;
    std::shared_ptr<Solver> solver;
  };
  const Named solvers[] = {{"SQP, sparse", make_native_solver({.qp = sparse_qp()})},
                           {"SQP, Riccati", make_native_solver({.qp = riccati_qp()})},
                           {"Ipopt", make_ipopt()}};
  std::printf("%-14s %14s %10s %9s %10s\n", "solver", "cost", "iterations", "time", "KKT");
  std::ofstream table("all_solvers.csv");
  table << "solver,cost,iterations,seconds\n";
  double least = INFINITY, most = -INFINITY;
  for (const Named& s : solvers) {
    const Solution plan = solve(ocp, {.intervals_per_phase = 60, .solver = s.solver});
    std::printf("%-14s %14.8f %10d %6.1f ms %10.1e  %s\n", s.name, plan.cost, plan.iterations,
                1e3 * plan.seconds, plan.kkt.scaled(), plan.message.c_str());
    table << '"' << s.name << "\"," << plan.cost << ',' << plan.iterations << ',' << plan.seconds
          << '\n';
    if (!plan.ok()) return 1;
    least = std::min(least, plan.cost);
    most = std::max(most, plan.cost);
    if (s.solver != solvers[0].solver) continue;
    Recording recording = record(ocp, plan.trajectory);
    recording.state_names = {"position [m]", "angle [rad]", "speed [m/s]", "rate [rad/s]"};
    recording.input_names = {"force [N]"};
    std::ofstream("crane.csv") << recording.trajectory_csv();
  }
  return most - least < 1e-5 * most ? 0 : 1;
}
