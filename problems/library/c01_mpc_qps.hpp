// Quadratic programs that walking robots solve in their control loops, with optima of 13 digits.
//
// LIPMWALK: a pendulum that walks (16 variables, 32 inequalities); WHLIPBAL: a wheeled pendulum
// that balances (50, 100); QUADCMPC: a quadruped (384, 256 inequalities, 192 equalities, bounds).
//
//   min 1/2 x'Px + q'x   subject to   G x <= h, A x = b, lb <= x <= ub
//
// The data are files, found through the environment variable SALTUS_REFERENCE_DATA.
// Source: qpsolvers, mpc_qpbenchmark; optima computed independently (interior point, then the
// active rows as equations).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/library/run_case.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::library {

inline constexpr const char* reference_data_variable = "SALTUS_REFERENCE_DATA";

struct MpcQp {
  std::string name;  ///< "LIPMWALK0"
  SparseQp qp;       ///< in the pattern of its entries other than zero
  double cost = 0.0;
  /// The first entries of the optimum; empty where it is not unique.
  std::vector<double> x;
};

/// The programs that mpc_qp/expected.csv in this folder lists. Throws InputError naming the file
/// that is missing or unreadable.
std::vector<MpcQp> read_mpc_qps(const std::filesystem::path& folder);

/// Case C01: all of them from zero, with the data that the environment names; skipped if it does
/// not.
CaseOutcome run_mpc_qps(SolverChoice choice);

inline constexpr const char* mpc_qps_id = "C01";
inline constexpr const char* mpc_qps_name = "mpc_qps";

}  // namespace saltus::library
