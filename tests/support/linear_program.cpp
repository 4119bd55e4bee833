#include "tests/support/linear_program.hpp"

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>

namespace saltus::testing {
namespace {

using Ipopt::Index;
using Ipopt::Number;

class Adapter : public Ipopt::TNLP {
 public:
  Adapter(const LinearProgram& program, LinearProgramResult& result)
      : lp_(program), result_(result) {}

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian,
                    IndexStyleEnum& style) override {
    n = static_cast<Index>(lp_.variables.size());
    m = static_cast<Index>(lp_.rows.size());
    nnz_jac = 0;
    for (const auto& row : lp_.rows) nnz_jac += static_cast<Index>(row.entries.size());
    nnz_hessian = 0;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index, Number* lower, Number* upper, Index, Number* row_lower,
                       Number* row_upper) override {
    // Ipopt reads values of +-1e19 and beyond as infinite.
    const auto finite = [](double b) { return std::clamp(b, -1e20, 1e20); };
    for (const Bounds& b : lp_.variables) {
      *lower++ = finite(b.lower);
      *upper++ = finite(b.upper);
    }
    for (const auto& row : lp_.rows) {
      *row_lower++ = finite(row.bounds.lower);
      *row_upper++ = finite(row.bounds.upper);
    }
    return true;
  }
  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool,
                          Number*) override {
    std::fill(x, x + n, 0.0);
    return true;
  }
  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = lp_.cost.dot(Eigen::Map<const VectorXd>(x, n));
    return true;
  }
  bool eval_grad_f(Index n, const Number*, bool, Number* gradient) override {
    Eigen::Map<VectorXd>(gradient, n) = lp_.cost;
    return true;
  }
  bool eval_g(Index, const Number* x, bool, Index, Number* g) override {
    for (const auto& row : lp_.rows) {
      double sum = 0.0;
      for (const auto& e : row.entries) sum += e.value * x[e.column];
      *g++ = sum;
    }
    return true;
  }
  bool eval_jac_g(Index, const Number*, bool, Index, Index, Index* row_of, Index* column_of,
                  Number* values) override {
    Index at = 0;
    for (std::size_t r = 0; r < lp_.rows.size(); ++r)
      for (const auto& e : lp_.rows[r].entries) {
        if (values) {
          values[at] = e.value;
        } else {
          row_of[at] = static_cast<Index>(r);
          column_of[at] = e.column;
        }
        ++at;
      }
    return true;
  }
  bool eval_h(Index, const Number*, bool, Number, Index, const Number*, bool, Index, Index*, Index*,
              Number*) override {
    return true;  // no entries
  }
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number*,
                         const Number*, Index, const Number*, const Number*, Number objective,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    result_.optimal = status == Ipopt::SUCCESS;
    result_.objective = objective;
    result_.x = Eigen::Map<const VectorXd>(x, n);
  }

 private:
  const LinearProgram& lp_;
  LinearProgramResult& result_;
};

}  // namespace

int LinearProgram::variable(const Bounds& bounds, double cost_coefficient) {
  variables.push_back(bounds);
  cost.conservativeResize(static_cast<Eigen::Index>(variables.size()));
  cost[cost.size() - 1] = cost_coefficient;
  return static_cast<int>(variables.size()) - 1;
}

void LinearProgram::row(std::vector<Entry> entries, const Bounds& bounds) {
  rows.push_back({std::move(entries), bounds});
}

LinearProgramResult solve(const LinearProgram& program) {
  LinearProgramResult result;
  Ipopt::SmartPtr<Ipopt::IpoptApplication> app = new Ipopt::IpoptApplication(false);
  app->Options()->SetIntegerValue("print_level", 0);
  app->Options()->SetStringValue("sb", "yes");
  app->Options()->SetStringValue("mehrotra_algorithm", "yes");  // for linear programs
  app->Options()->SetStringValue("jac_c_constant", "yes");
  app->Options()->SetStringValue("jac_d_constant", "yes");
  app->Options()->SetStringValue("hessian_constant", "yes");
  app->Options()->SetNumericValue("tol", 1e-9);
  app->Options()->SetNumericValue("bound_relax_factor", 0.0);
  if (app->Initialize() != Ipopt::Solve_Succeeded) return result;
  app->OptimizeTNLP(new Adapter(program, result));
  return result;
}

}  // namespace saltus::testing
