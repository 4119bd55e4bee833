// Counts how often, and in how many threads, a program evaluates the formulas of its user.
#include <gtest/gtest.h>

#include <mutex>
#include <set>
#include <thread>

#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

struct Watched {  // x' = u - x
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    const std::lock_guard lock(mutex);
    ++evaluations;
    threads.insert(std::this_thread::get_id());
    return u - x;
  }
  static void forget() {
    evaluations = 0;
    threads.clear();
  }
  static inline std::mutex mutex;
  static inline int evaluations = 0;
  static inline std::set<std::thread::id> threads;
};

MultipleShooting watched(int threads) {
  Phase<1, 1> phase{"motion", Watched{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("watched");
  ocp.start_at({1}).then(phase);
  return MultipleShooting(
      ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4(), .threads = threads});
}

// Intervals with identical arguments share one evaluation.
TEST(Evaluations, EqualIntervalsAreEvaluatedOnce) {
  MultipleShooting shooting = watched(1);
  NonlinearProgram& nlp = shooting.nlp();
  const VectorXd equal = shooting.initial_guess().w;  // the start everywhere, and no input
  VectorXd different = equal, rows(nlp.rows()), entries(nlp.jacobian_pattern().entries());
  for (int k = 0; k < 10; ++k) different[shooting.layout().input(0, k)] = 0.1 * k;
  for (const bool slopes : {false, true}) {
    const auto evaluations_at = [&](const VectorXd& w) {
      VectorXd away = w;
      away[0] += 1.0;
      EXPECT_TRUE(nlp.constraints(away.data(), rows.data()));  // w is new
      Watched::forget();
      EXPECT_TRUE(slopes ? nlp.jacobian(w.data(), entries.data())
                         : nlp.constraints(w.data(), rows.data()));
      return Watched::evaluations;
    };
    const int once = evaluations_at(equal);
    EXPECT_GT(once, 0);
    EXPECT_EQ(evaluations_at(different), 10 * once);
  }
}

TEST(Evaluations, AreDistributedToAllThreads) {
  for (const int threads : {1, 2, 3}) {
    MultipleShooting shooting = watched(threads);
    const VectorXd w = shooting.initial_guess().w;
    VectorXd rows(shooting.nlp().rows());
    Watched::forget();
    EXPECT_TRUE(shooting.nlp().constraints(w.data(), rows.data()));
    EXPECT_EQ(Watched::threads.size(), static_cast<std::size_t>(threads));
  }
}

}  // namespace
}  // namespace saltus
