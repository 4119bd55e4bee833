// `saltus bench answer`: the part of the benchmark suite in this program. It reads one JSON request
// per line of the standard input and writes one answer per line, so that the script of the suite
// can alternate between our solvers and others.
//
//   {"do": "describe"}
//       version, compiler, flags, processor; problems and solvers
//   {"do": "version"}
//       version and commit
//   {"do": "export", "problem": NAME, "instance": I, "file": FILE}
//       writes the program for all solvers
//   {"do": "solve", "problem": NAME, "instance": I, "solver": NAME, "start": START,
//    "tolerance": 1e-8}
//       START is "own start", or "guess", "guess rolled out" or "warm" if the program has it;
//       status of the solver and values of the judge, for quadratic programs also the point; "file"
//       instead of problem and instance: a program of qp_file.hpp
//   {"do": "judge", "problem": NAME, "w": [], "lambda": [], "z": []}
//       for a nonlinear problem: cost and KKT residual of a point of any origin
//
// The answer to an invalid request is {"error": sentence}.
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

/// Answers requests until the input ends.
void answer_requests(std::istream& in, std::ostream& out);

}  // namespace saltus::bench
