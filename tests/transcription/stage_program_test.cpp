// Stages that a shooting program fills directly equal the stages of its sparse model, entry by
// entry, for any change of rows, inputs and windows. The points of both are equal too.
#include "saltus/transcription/stage_program.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/solver/convexify.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Mass {  // x = (position, speed), u = (pull, brake)
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u, const Vec<S, 1>& p) const {
    return {x[1], u[0] - 0.5 * u[1] + p[0]};
  }
};
struct Swing {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u, const Vec<S, 1>& p) const {
    return {x[1], sin(x[0]) * p[0] + u[0] - u[1] * x[1]};
  }
};

constexpr auto speed = [](const auto&, const auto& x) { return x[1]; };
constexpr auto state = [](const auto&, const auto& x) { return x; };
constexpr auto input = [](const auto&, const auto&, const auto& u) { return u; };
constexpr auto power = [](const auto&, const auto& x, const auto& u) { return x[1] + 2.0 * u[0]; };

template <class Dynamics>
Phase<2, 2, 1> phase_of(Dynamics dynamics, Bounds duration) {
  Phase<2, 2, 1> phase{"motion", dynamics, duration};
  phase.data("push", Vec<double, 1>{0.3})
      .bound_input(0, between(-1.0, 1.0))
      .bound_input(1, exactly(0.0), Window{.to = 0.4})
      .bound_input(1, between(0.0, 2.0), Window{.from = 0.4})
      .nominal(Vec<double, 2>{2.0, 0.5}, Vec<double, 2>{3.0, 1.0})
      .penalise_change(Vec<double, 2>{0.1, 0.2})
      .keep("speed", speed, between(-1.0, 1.0), Window{.from = 0.3}, soft("speed", 4.0))
      .keep("power", power, at_most(1.5), Window{.to = 0.6}, huber("power", 2.0, 0.1))
      .keep("brake", input, at_most(1.7), Window{.from = 0.2}, soft("brake", 3.0, Penalty::L2))
      .keep("lane", speed, between(-3.0, 3.0))
      .reach("end", speed, exactly(0.2), soft("end", 5.0))
      .track("rest", state, Vec<double, 2>{1.0, 0.1})
      .track("effort", input, Vec<double, 2>{0.1, 0.2});
  return phase;
}

MultipleShooting with_event(bool nonlinear) {
  auto phase = nonlinear ? phase_of(Swing{}, exactly(1.0)) : phase_of(Mass{}, exactly(1.0));
  phase.keep("gate", power, at_most(0.8), Window{.from = event("gate")})
      .bound_input(0, exactly(0.25), Window{.from = event("gate")});
  OptimalControlProblem ocp("with an event");
  ocp.schedule(Schedule({"closed", "open"}, {{"gate", 0.437}})).start_at({0.5, 0.1}).then(phase);
  return MultipleShooting(std::move(ocp), {.intervals_per_phase = 6, .integrator = runge_kutta4()});
}

// Free duration, a jump and an unknown. They give globals and a stage in front.
MultipleShooting with_globals() {
  Phase<2, 2, 1> first = phase_of(Swing{}, between(0.7, 2.0));
  first.guess_duration(1.0);
  Phase<2, 2, 1> second{"rest", Swing{}, exactly(0.5)};
  second.unknown("pull", Vec<double, 1>{0.4}, between(0.1, 1.0))
      .track("still", state, Vec<double, 2>{1.0, 1.0})
      .track("effort", input, Vec<double, 2>{0.1, 0.2});
  OptimalControlProblem ocp("with globals");
  ocp.start_within({between(0.0, 1.0), exactly(0.2)}, Vec<double, 2>{0.5, 0.2});
  ocp.then(first).then(second, jump<2>("bounce", [](const auto&, const auto& x) {
                         return Vec<std::decay_t<decltype(x[0])>, 2>{x[0], -0.5 * x[1]};
                       }));
  return MultipleShooting(std::move(ocp), {.intervals_per_phase = 5, .integrator = runge_kutta4()});
}

// Continuous ramps, and an end that equals the start: stages carry variables.
MultipleShooting closed_with_ramps() {
  Phase<2, 2, 1> phase{"round", Mass{}, exactly(1.0)};
  phase.data("push", Vec<double, 1>{0.3})
      .inputs(InputParametrisation::piecewise_linear_continuous)
      .bound_input(0, between(-1.0, 1.0))
      .keep("power", power, at_most(1.5))
      .track("rest", state, Vec<double, 2>{1.0, 0.1})
      .track("effort", input, Vec<double, 2>{0.1, 0.2});
  OptimalControlProblem ocp("closed");
  ocp.start_within({between(-1.0, 1.0), between(-1.0, 1.0)}, Vec<double, 2>{0.5, 0.2});
  ocp.then(phase).close();
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = 5, .integrator = zero_order_hold()});
}

constexpr double rounding = 1e-12;  // sums in a different order

template <class A, class B>
void expect_near(const A& a, const B& b, const char* what) {
  ASSERT_EQ(a.rows(), b.rows()) << what;
  ASSERT_EQ(a.cols(), b.cols()) << what;
  for (int i = 0; i < a.rows(); ++i)
    for (int j = 0; j < a.cols(); ++j)
      if (a(i, j) != b(i, j)) {
        EXPECT_NEAR(a(i, j), b(i, j), rounding * (1.0 + std::abs(b(i, j))))
            << what << " " << i << ", " << j;
      }
}

void expect_same(const qp::StageQp& a, const qp::StageQp& b) {
  ASSERT_EQ(a.stages.size(), b.stages.size());
  ASSERT_EQ(a.fixed_start, b.fixed_start);
  if (b.fixed_start) expect_near(a.start, b.start, "start");
  for (std::size_t k = 0; k < a.stages.size(); ++k) {
    SCOPED_TRACE("stage " + std::to_string(k));
    const qp::Stage &s = a.stages[k], &t = b.stages[k];
    ASSERT_EQ(s.nx, t.nx);
    ASSERT_EQ(s.nu, t.nu);
    const int nx = s.nx, nu = s.nu;
    EXPECT_EQ(s.resultant_size, t.resultant_size);
    expect_near(s.Q.topLeftCorner(nx, nx), t.Q.topLeftCorner(nx, nx), "Q");
    expect_near(s.R.topLeftCorner(nu, nu), t.R.topLeftCorner(nu, nu), "R");
    expect_near(s.S.topLeftCorner(nu, nx), t.S.topLeftCorner(nu, nx), "S");
    expect_near(s.q.head(nx), t.q.head(nx), "q");
    expect_near(s.r.head(nu), t.r.head(nu), "r");
    EXPECT_NEAR(s.constant, t.constant, rounding * (1.0 + std::abs(t.constant)));
    expect_near(s.u_lower.head(nu), t.u_lower.head(nu), "u_lower");
    expect_near(s.u_upper.head(nu), t.u_upper.head(nu), "u_upper");
    if (k > 0 || !b.fixed_start) {
      expect_near(s.x_lower.head(nx), t.x_lower.head(nx), "x_lower");
      expect_near(s.x_upper.head(nx), t.x_upper.head(nx), "x_upper");
    }
    if (k + 1 < a.stages.size()) {
      const int next = t.A.rows() > 0 ? b.stages[k + 1].nx : 0;
      expect_near(s.A.topLeftCorner(next, nx), t.A.topLeftCorner(next, nx), "A");
      expect_near(s.B.topLeftCorner(next, nu), t.B.topLeftCorner(next, nu), "B");
      expect_near(s.b.head(next), t.b.head(next), "b");
    }
    ASSERT_EQ(s.groups.size(), t.groups.size());
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      SCOPED_TRACE("group " + std::to_string(g));
      const qp::RowGroup &c = s.groups[g], &d = t.groups[g];
      ASSERT_EQ(c.rows, d.rows);
      ASSERT_EQ(c.columns, d.columns);
      const int columns = static_cast<int>(d.columns.size());
      expect_near(c.M.topLeftCorner(c.rows, columns), d.M.topLeftCorner(d.rows, columns), "M");
      expect_near(c.lower.head(c.rows), d.lower.head(c.rows), "lower");
      expect_near(c.upper.head(c.rows), d.upper.head(c.rows), "upper");
      if (!d.soft) continue;
      expect_near(c.l1.head(c.rows), d.l1.head(c.rows), "l1");
      expect_near(c.l2.head(c.rows), d.l2.head(c.rows), "l2");
    }
  }
}

// Fills the stages in both ways and solves both. The model is linearised at random w and
// multipliers.
class Pair {
 public:
  explicit Pair(MultipleShooting& shooting)
      : shooting_(shooting),
        program_(shooting.editable_program()),
        is_exact_(program_.is_linear_quadratic()),
        model_(program_),
        direct_model_(program_),
        map_(model_.qp(), shooting.stages()),
        sparse_(qp::make_sparse_solver_by_stages(model_.qp(), shooting.stages(), riccati)),
        direct_(program_, direct_model_, riccati),
        at_(program_.variables()),
        lambda_(program_.rows()) {}

  void compare(bool solves) {
    NlpPoint point = shooting_.initial_guess();
    std::uniform_real_distribution<double> some(-0.3, 0.3);
    for (int i = 0; i < at_.size(); ++i)
      at_[i] = is_exact_ ? 0.0
                         : std::clamp(point.w[i] + some(random_), program_.lower()[i],
                                      program_.upper()[i]);
    for (double& l : lambda_) l = some(random_);
    ASSERT_TRUE(model_.linearise(program_, at_, lambda_, Curvature::gauss_newton));
    ASSERT_TRUE(direct_.linearise(at_, lambda_, Curvature::gauss_newton));
    ASSERT_EQ(map_.fill(model_.qp()), qp::StageFill::filled);
    direct_.fill();
    expect_same(direct_.stages(), map_.stages());
    if (!solves) return;
    point.lambda.setZero(program_.rows());
    point.z.setZero(program_.variables());
    NlpPoint other = point;
    const qp::QpResult a = direct_.solve(direct_model_.qp(), point, false);
    const qp::QpResult b = sparse_->solve(model_.qp(), other, false);
    ASSERT_EQ(a.status, b.status);
    ASSERT_EQ(a.status, qp::QpStatus::optimal);
    EXPECT_EQ(a.iterations, b.iterations);
    expect_near_points(point, other);
  }

  // Only the start changes, and no other number is written again.
  void compare_after_start(const VectorXd& start) {
    shooting_.start_at(shooting_.data().start_time, start);
    compare_bounds();
  }

  // Compares the stages after a change of bounds, without a new linearisation.
  void compare_bounds() {
    direct_.fill();
    model_.update_bounds(program_);
    ASSERT_EQ(map_.fill(model_.qp()), qp::StageFill::filled);
    expect_same(direct_.stages(), map_.stages());
  }

 private:
  static std::unique_ptr<qp::StageQpSolver> riccati(const qp::StageQp& capacity) {
    return qp::make_riccati_solver(capacity, {});
  }
  static void expect_near_points(const NlpPoint& a, const NlpPoint& b) {
    EXPECT_LT((a.w - b.w).lpNorm<Eigen::Infinity>(), 1e-9);
    EXPECT_LT((a.lambda - b.lambda).lpNorm<Eigen::Infinity>(), 1e-8);
    EXPECT_LT((a.z - b.z).lpNorm<Eigen::Infinity>(), 1e-8);
  }

  MultipleShooting& shooting_;
  ShootingProgram& program_;
  bool is_exact_;
  QuadraticModel model_, direct_model_;
  qp::StageMap map_;
  std::unique_ptr<qp::QpSolver> sparse_;
  StageProgram direct_;
  VectorXd at_, lambda_;
  std::mt19937 random_{7};
};

TEST(StageProgram, MatchesTheSparseModelForAnyEventTimes) {
  for (const bool nonlinear : {false, true}) {
    SCOPED_TRACE(nonlinear ? "nonlinear" : "linear-quadratic");
    MultipleShooting shooting = with_event(nonlinear);
    Pair pair(shooting);
    int k = 0;
    for (const double gate : {0.437, -1.0, 0.2, 0.5, 0.93, 2.0, 0.437}) {
      SCOPED_TRACE("gate at " + std::to_string(gate));
      shooting.retime("gate", gate);
      shooting.set_data("push", Vec<double, 1>{0.1 * ++k});
      shooting.set_previous_input(k % 2 == 0 ? Vec<double, 2>{0.1, 0.2}
                                             : Vec<double, 2>{std::nan(""), 0.3});
      pair.compare(!nonlinear);
      pair.compare_after_start(Vec<double, 2>{0.4, 0.05 * k});
    }
    shooting.set_penalty_weight("power", 7.0);
    pair.compare(!nonlinear);
  }
}

TEST(StageProgram, CurrentBoundsMatchTheStages) {
  MultipleShooting shooting = with_globals();
  Pair pair(shooting);
  pair.compare(false);
  for (const double most : {1.8, 1.1}) {
    shooting.set_remaining(between(0.8, most), unbounded());
    pair.compare_bounds();
  }
}

// A measured start replaces a start that was free within bounds, and nothing else changes.
TEST(StageProgram, MeasuredStartIsGiven) {
  Phase<2, 2, 1> phase{"rest", Mass{}, exactly(1.0)};
  phase.data("push", Vec<double, 1>{0.3})
      .track("rest", state, Vec<double, 2>{1.0, 0.1})
      .track("effort", input, Vec<double, 2>{0.1, 0.2});
  OptimalControlProblem ocp("measured");
  ocp.start_within({between(0.0, 1.0), exactly(0.2)}, Vec<double, 2>{0.5, 0.2});
  MultipleShooting shooting(ocp.then(phase),
                            {.intervals_per_phase = 5, .integrator = zero_order_hold()});
  Pair pair(shooting);
  pair.compare(true);
  pair.compare_after_start(Vec<double, 2>{0.7, 0.2});
  pair.compare_after_start(Vec<double, 2>{0.6, 0.3});
}

TEST(StageProgram, HasGlobalsRampsAndClosings) {
  MultipleShooting globals = with_globals();
  Pair(globals).compare(false);
  MultipleShooting closed = closed_with_ramps();
  Pair pair(closed);
  pair.compare(true);
  closed.set_data("push", Vec<double, 1>{-0.2});
  pair.compare(true);
}

}  // namespace
}  // namespace saltus
