#include "saltus/qp/qp_result.hpp"

namespace saltus::qp {

const char* describe(QpStatus status) {
  switch (status) {
    case QpStatus::optimal:
      return "The optimum was found.";
    case QpStatus::infeasible:
      return "No point satisfies the rows and bounds.";
    case QpStatus::unbounded:
      return "The cost is unbounded below.";
    case QpStatus::iteration_limit:
      return "The iteration limit was reached.";
    case QpStatus::deadline:
      return "The deadline passed before the optimum was reached.";
    case QpStatus::numerical_failure:
      return "The linear algebra failed.";
    case QpStatus::invalid_problem:
      return "The data are invalid: NaN or crossed bounds.";
  }
  return "";
}

}  // namespace saltus::qp
