// A quadratic program in stages for ProxDDP of libaligator, which has no Python interface: built by
// aligator.py at first use.
#include <algorithm>
#include <aligator/core/traj-opt-problem.hpp>
#include <aligator/core/vector-space.hpp>
#include <aligator/modelling/constraints.hpp>
#include <aligator/modelling/costs/quad-costs.hpp>
#include <aligator/modelling/linear-discrete-dynamics.hpp>
#include <aligator/modelling/linear-function.hpp>
#include <aligator/solvers/proxddp/solver-proxddp.hpp>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::Map<const MatrixXd>;
using Vector = Eigen::Map<const VectorXd>;
using Cost = aligator::QuadraticCostTpl<double>;
using Dynamics = aligator::dynamics::LinearDiscreteDynamicsTpl<double>;
using Rows = aligator::LinearFunctionTpl<double>;
using Box = aligator::BoxConstraintTpl<double>;
using Solver = aligator::SolverProxDDPTpl<double>;

struct Program {
  std::vector<xyz::polymorphic<aligator::StageModelTpl<double>>> stages;
  std::optional<aligator::TrajOptProblemTpl<double>> problem;
  std::unique_ptr<Solver> solver;
};

}  // namespace

extern "C" {

Program* aligator_new() { return new Program; }

void aligator_delete(Program* p) { delete p; }

// next = A x + B u + b; 1/2 x'Qx + x'Su + 1/2 u'Ru + q'x + r'u; low <= C x + D u <= high. Matrices
// are column-major.
void aligator_stage(Program* p, int nx, int nu, int rows, const double* Q, const double* S,
                    const double* R, const double* q, const double* r, const double* A,
                    const double* B, const double* b, const double* C, const double* D,
                    const double* low, const double* high) {
  const Cost cost(Matrix(Q, nx, nx), Matrix(R, nu, nu), Matrix(S, nx, nu), Vector(q, nx),
                  Vector(r, nu));
  aligator::StageModelTpl<double> stage(
      cost, Dynamics(Matrix(A, nx, nx), Matrix(B, nx, nu), Vector(b, nx)));
  if (rows > 0)
    stage.addConstraint(Rows(Matrix(C, rows, nx), Matrix(D, rows, nu), VectorXd::Zero(rows)),
                        Box(Vector(low, rows), Vector(high, rows)));
  p->stages.emplace_back(std::move(stage));
}

// Adds the last stage, which has no inputs, and creates the solver. Returns 0 on success.
int aligator_finish(Program* p, int nx, int rows, const double* Q, const double* q, const double* C,
                    const double* low, const double* high, const double* start, double tolerance,
                    double penalty, int iterations) try {
  const Cost cost(Matrix(Q, nx, nx), MatrixXd::Zero(0, 0), Vector(q, nx), VectorXd::Zero(0));
  p->problem.emplace(VectorXd(Vector(start, nx)), p->stages, cost);
  if (rows > 0)
    p->problem->addTerminalConstraint(
        Rows(Matrix(C, rows, nx), MatrixXd::Zero(rows, 0), VectorXd::Zero(rows)),
        Box(Vector(low, rows), Vector(high, rows)));
  p->solver = std::make_unique<Solver>(tolerance, penalty, static_cast<std::size_t>(iterations));
  p->solver->force_initial_condition_ = true;
  p->solver->setup(*p->problem);
  return 0;
} catch (const std::exception&) {
  return 1;
}

// Starts from x_0, u_0, x_1, ..., multipliers of the rows and costates, and overwrites them with
// the result. Returns the number of iterations, negative without convergence, -100000 after an
// exception.
int aligator_solve(Program* p, double* w, double* rows, double* costates) try {
  const auto& stages = p->problem->stages_;
  std::vector<VectorXd> xs, us, vs, lams;
  const double *at = w, *row = rows, *costate = costates;
  const int nx = static_cast<int>(p->problem->getInitState().size());
  for (const auto& stage : stages) {
    xs.emplace_back(Vector(at, nx));
    us.emplace_back(Vector(at + nx, stage->nu()));
    at += nx + stage->nu();
    vs.emplace_back(Vector(row, stage->nc()));
    row += stage->nc();
  }
  xs.emplace_back(Vector(at, nx));
  vs.emplace_back(Vector(row, p->problem->term_cstrs_.totalDim()));  // empty if there are none
  for (std::size_t k = 0; k < xs.size(); ++k, costate += nx) lams.emplace_back(Vector(costate, nx));
  const bool found = p->solver->run(*p->problem, xs, us, vs, lams);
  const auto& results = p->solver->results_;
  double* out = w;
  for (std::size_t k = 0; k < results.xs.size(); ++k) {
    out = std::copy_n(results.xs[k].data(), nx, out);
    if (k < stages.size()) out = std::copy_n(results.us[k].data(), stages[k]->nu(), out);
  }
  out = rows;
  for (const VectorXd& v : results.vs) out = std::copy_n(v.data(), v.size(), out);
  out = costates;
  for (const VectorXd& l : results.lams) out = std::copy_n(l.data(), l.size(), out);
  const int count = static_cast<int>(results.num_iters);
  return found ? count : -count - 1;
} catch (const std::exception&) {
  return -100000;
}
}
