// `saltus bench answer`: the program's side of the benchmark suite. One request in JSON per line of
// the standard input, one answer per line of the output, so that the script that runs the suite can
// take turns between our solvers and others.
//
//   {"do": "describe"}
//       version, compiler, flags, processor; problems and solvers
//   {"do": "export", "problem": NAME, "instance": I, "file": FILE}
//       writes the program as every solver reads it
//   {"do": "solve", "problem": NAME, "instance": I, "solver": NAME, "start": "cold"|"warm",
//    "tolerance": 1e-8}
//       what the solver says and the judge's figures, of quadratic programs its point, too; "file"
//       in place of problem and instance: a program of qp_file.hpp
//   {"do": "judge", "problem": NAME, "w": [], "lambda": [], "z": []}
//       of a nonlinear problem: cost and KKT residual of a point that anybody found
//
// A request that cannot be met is answered by {"error": sentence}.
#pragma once

#include <iosfwd>
#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace saltus::bench {

class Answerer {
 public:
  Answerer();
  ~Answerer();
  nlohmann::ordered_json answer(const nlohmann::json& request);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Until the input ends.
void answer_requests(std::istream& in, std::ostream& out);

}  // namespace saltus::bench
