// Files of quadratic programs for our solvers and others: JSON, "saltus-qp 1".
//
// hessian (lower triangle) and jacobian are lists row, col, value; sides that are null do not
// exist. `stages` holds states, inputs and rows besides the dynamics of each stage, in the order of
// flat_qp.hpp; `guess` is a start, `warm` one with multipliers, `optimum` the cost where it is
// known.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "benchmarks/suite/qp_problems.hpp"

namespace saltus::bench {

/// A list of the entries; json_sides() writes null for infinity, which JSON does not have.
nlohmann::ordered_json json_list(const VectorXd& v);
nlohmann::ordered_json json_sides(const VectorXd& v);
nlohmann::ordered_json program_json(const QpProblem& problem, int number,
                                    const QpInstance& instance);
nlohmann::ordered_json point_json(const PrimalDualPoint& point);

/// Reads a program, with its stages if the file has them. Throws InputError with the name of the
/// file and the mistake.
QpInstance read_program(const std::filesystem::path& file);

}  // namespace saltus::bench
