#include "saltus/solver/restoration_program.hpp"

#include <vector>

namespace saltus {

RestorationProgram::RestorationProgram(NonlinearProgram& program)
    : SlackProgram(program, 2 * program.rows(), weight) {
  std::vector<Constant> constants;
  for (int i = 0; i < m_; ++i) {
    constants.push_back({i, n_ + i, -1.0});
    constants.push_back({i, n_ + m_ + i, 1.0});
  }
  set_pattern(m_, constants);
}

bool RestorationProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(w, g)) return false;
  for (int i = 0; i < m_; ++i) g[i] += w[n_ + m_ + i] - w[n_ + i];
  return true;
}

std::string RestorationProgram::describe_variable(int i) const {
  return i < n_ ? program_.describe_variable(i)
                : "violation of " + program_.describe_row((i - n_) % m_);
}

}  // namespace saltus
