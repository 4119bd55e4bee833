// Phases that end where a guard crosses zero: grazing guards, unreachable guards, guards crossed
// earlier or in the wrong direction, and two guards in sequence. The system is a thrown ball with a
// known height. The judge simulates its path with CVODE.
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

constexpr double gravity = 9.81;  // m/s^2

struct Flight {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], S(u[0] - gravity)};
  }
};
struct Above {
  double height;
  template <class S, class X>
  S operator()(const S&, const X& x) const {
    return x[0] - height;
  }
};

// The guard along each phase. It must be zero at the end, cross in the declared direction, and not
// cross earlier.
std::string check_crossings(const std::vector<OutsidePhase>& phases,
                            const std::vector<double>& heights,
                            const std::vector<Crossing>& crossings, const Solution& solution) {
  const auto& pieces = solution.trajectory.pieces();
  for (std::size_t j = 0; j < heights.size(); ++j) {
    const double sign = crossings[j] == Crossing::rising ? 1.0 : -1.0;
    double lowest = infinity, passed = 0.0;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      if (pieces[k].phase != static_cast<int>(j)) continue;
      PlanPiece piece{pieces[k].phase,       pieces[k].start,     pieces[k].length,
                      pieces[k].state,       pieces[k].end_state, pieces[k].coefficients,
                      pieces[k].coefficients};
      VectorXd x(3);
      x << piece.state, 0.0;
      const bool is_last = k + 1 == pieces.size() || pieces[k + 1].phase != pieces[k].phase;
      flow(phases[j], piece, x, [&](double a, double b, const auto& at) {
        double state[3];
        for (int s = 0; s <= 8; ++s) {
          const double t = a + (b - a) * s / 8.0;
          if (is_last && t > piece.start + piece.length - 1e-9) continue;
          at(t, state);
          const double g = sign * (state[0] - heights[j]);
          lowest = std::min(lowest, g);
          if (lowest < -1e-5) passed = std::max(passed, g);
        }
      });
      if (is_last) {
        const double rate = sign * x[1];
        if (std::abs(x[0] - heights[j]) > 1e-5)
          return "event: phase '" + phases[j].name + "' does not end at its guard";
        if (rate < -1e-4)
          return "event: the guard of '" + phases[j].name + "' is crossed in the wrong direction";
      }
    }
    if (passed > 1e-5) return "event: the guard of '" + phases[j].name + "' was crossed earlier";
  }
  return {};
}

}  // namespace

Instance hybrid_events(Random& random) {
  const double speed = random.uniform(2.0, 8.0), apex = speed * speed / (2.0 * gravity);
  const double thrust = random.chance(0.5) ? 0.0 : random.log_uniform(1e-3, 1.0);
  Instance instance;
  instance.problem.start_at({0.0, speed}).costs(CostRule::integrated);
  std::vector<double> heights;
  std::vector<Crossing> crossings;
  const auto add = [&](const std::string& name, double height, Crossing crossing, double guess,
                       bool is_last) {
    Twin<2, 1> twin(name, Flight{}, between(1e-3, 5.0));
    twin.bound_input(0, between(-thrust, thrust)).minimise("effort", Effort{1.0});
    twin.phase.ends_when("guard", Above{height}, crossing).guess_duration(guess);
    if (is_last && random.chance(0.3)) twin.minimise_at_end("time", Time{});
    instance.problem.then(twin.phase);
    instance.phases.push_back(twin.outside);
    heights.push_back(height);
    crossings.push_back(crossing);
  };
  const double up = speed / gravity;  // s to the apex
  instance.may_be_either = true;
  switch (random.integer(0, 3)) {
    case 0:  // near the apex: grazing, or never reached
      add("rise",
          apex * (1.0 + random.log_uniform(1e-10, 1e-1) * (random.chance(0.5) ? 1.0 : -1.0)),
          Crossing::rising, up * random.uniform(0.5, 1.5), true);
      break;
    case 1:  // falls through a height after it rises through it; the guess is near either crossing
      add("throw", apex * random.uniform(0.2, 0.95),
          random.chance(0.5) ? Crossing::rising : Crossing::falling, up * random.uniform(0.2, 2.0),
          true);
      break;
    case 2:  // two guards in order, or the second one is crossed first
      add("rise", apex * random.uniform(0.3, 0.9), Crossing::rising, up * random.uniform(0.3, 1.0),
          false);
      add("fall", apex * random.uniform(0.1, 0.9), Crossing::falling, up * random.uniform(0.3, 2.0),
          true);
      break;
    default:  // a lower guard that must rise after it was crossed: only the wrong direction remains
      add("rise", apex * random.uniform(0.5, 0.9), Crossing::rising, up * random.uniform(0.3, 2.0),
          false);
      add("rise again", apex * random.uniform(0.1, 0.4), Crossing::rising,
          up * random.uniform(0.3, 2.0), true);
      break;
  }
  instance.is_kkt_judged = false;
  const auto phases = instance.phases;
  instance.further = [=](const Solution& solution) {
    return check_crossings(phases, heights, crossings, solution);
  };
  return instance;
}

}  // namespace saltus::corpus
