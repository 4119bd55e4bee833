// Quadratic programs as files that our solvers and those of others read: JSON, "saltus-qp 1".
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

nlohmann::ordered_json program_json(const QpProblem& problem, int number,
                                    const QpInstance& instance);
nlohmann::ordered_json point_json(const PrimalDualPoint& point);

/// With its stages, if it says that it has them. Throws InputError naming the file and what is
/// wrong with it.
QpInstance read_program(const std::filesystem::path& file);

}  // namespace saltus::bench
