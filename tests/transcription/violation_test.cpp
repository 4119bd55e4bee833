// Messages about programs without a solution: conflicting terms by their multipliers, and dependent
// equations.
#include "saltus/transcription/violation.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "saltus/transcription/dependent_rows.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// --- conflicts ----------------------------------------------------------------------------------

MultipleShooting with_terms(const std::vector<std::string>& names) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  for (const std::string& name : names) phase.keep(name, state, at_most(1.0));
  phase.keep("soft", state, at_most(1.0), {}, soft("soft", 1.0));
  OptimalControlProblem ocp("terms");
  ocp.start_at({0}).then(phase);
  return MultipleShooting(ocp, ten);
}

// Message for given multipliers of the rows of these terms at one node.
std::string conflict(MultipleShooting& shooting,
                     const std::vector<std::pair<std::string, double>>& forces, int node,
                     const std::string& violated) {
  const ShootingProgram& program = shooting.program();
  VectorXd lambda = VectorXd::Zero(program.rows());
  for (const shooting::RowInstance& instance : program.row_instances())
    for (const auto& [name, force] : forces)
      if (shooting.problem().phases()[0].terms[instance.term].name == name &&
          instance.block.point.node == node)
        lambda[instance.first_row] = force;
  return describe_conflict(program, lambda, violated);
}

TEST(Conflict, NamesTheStrongestOpposingTerms) {
  MultipleShooting shooting = with_terms({"a", "b", "c", "d", "e"});
  const std::string violated = "phase 'motion', term 'a', row 0";
  for (const int node : {1, 5, 10})  // at any node
    EXPECT_EQ(conflict(shooting, {{"a", 1.0}, {"b", 0.2}, {"c", -0.5}}, node, violated),
              "in conflict with phase 'motion', term 'c'; phase 'motion', term 'b'");
  // The message omits terms with small multipliers, a fourth term, and terms that may be violated.
  EXPECT_EQ(conflict(shooting, {{"a", 1.0}, {"b", 0.2}, {"c", 1e-4}}, 5, violated),
            "in conflict with phase 'motion', term 'b'");
  EXPECT_EQ(
      conflict(shooting, {{"a", 1.0}, {"b", 0.2}, {"c", 0.3}, {"d", 0.4}, {"e", 0.5}}, 5, violated),
      "in conflict with phase 'motion', term 'e'; phase 'motion', term 'd'; "
      "phase 'motion', term 'c'");
  EXPECT_EQ(conflict(shooting, {{"a", 1.0}, {"soft", 1.0}}, 5, violated), "");
  EXPECT_EQ(describe_conflict(shooting.program(), VectorXd(), violated), "");
}

// --- equations ----------------------------------------------------------------------------------

// The input is given as 0.3, and a term requires it to be `push`.
std::string dependent_of_given_input(double push) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, exactly(0.3))
      .keep("push", input, exactly(push))
      .reach("end", state, at_most(5.0));
  OptimalControlProblem ocp("given input");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  return describe_dependent_rows(shooting.editable_program(), shooting.initial_guess().w);
}

TEST(DependentRows, ConstantEquationIsReportedOnlyIfViolated) {
  EXPECT_EQ(dependent_of_given_input(0.3), "");
  for (const double other : {0.1, 0.5})
    EXPECT_NE(dependent_of_given_input(other).find("term 'push'"), std::string::npos) << other;
}

// This also holds at a point that satisfies both.
TEST(DependentRows, NamesADuplicateEquation) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.reach("first", state, exactly(2.0)).reach("second", state, exactly(2.0));
  OptimalControlProblem ocp("twice");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  VectorXd w = shooting.initial_guess().w;
  for (const double end : {1.0, 2.0}) {
    w[shooting.layout().state(0, 10)] = end;
    const std::string text = describe_dependent_rows(shooting.editable_program(), w);
    EXPECT_NE(text.find("13 equations"), std::string::npos) << text;  // start, ten intervals, two
    EXPECT_NE(text.find("term 'second'"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace saltus
