// Quadratic programs from the control loops of walking robots, with optima of 13 digits.
// LIPMWALK: a walking pendulum (16 variables, 32 inequalities); WHLIPBAL: a balancing wheeled
// pendulum (50, 100); QUADCMPC: a quadruped (384, 256 inequalities, 192 equalities, bounds).
//
//   min 1/2 x'Px + q'x   subject to   G x <= h, A x = b, lb <= x <= ub
//
// The data are files in the folder named by the environment variable SALTUS_REFERENCE_DATA.
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
  std::string name;  ///< for example "LIPMWALK0"
  qp::SparseQp qp;   ///< its pattern contains the non-zero entries
  double cost = 0.0;
  /// The first entries of the optimum; empty if it is not unique.
  std::vector<double> x;
};

/// The folder that the environment names, or null if the variable is unset or empty.
const char* reference_data_folder();

/// Reads the programs listed in mpc_qp/expected.csv of this folder. Throws InputError with the name
/// of a missing or unreadable file.
std::vector<MpcQp> read_mpc_qps(const std::filesystem::path& folder);

/// Solves all programs from zero (case C01). Skipped if the environment names no data.
CaseOutcome run_mpc_qps(SolverChoice choice);

inline constexpr const char* mpc_qps_id = "C01";
inline constexpr const char* mpc_qps_name = "mpc_qps";

}  // namespace saltus::library
