// The program `saltus`: its problems by name.
#include <utility>
#include <vector>

#include "problems/biped/report/scripts.hpp"
#include "problems/push_recovery/push_recovery.hpp"
#include "problems/quadruped/quadruped.hpp"
#include "problems/suite/check_verb.hpp"
#include "problems/suite/library_problems.hpp"
#include "problems/suite/suite.hpp"
#include "problems/sway/sway.hpp"
#include "problems/whole_body/whole_body.hpp"
#include "saltus/app/logs_verb.hpp"
#include "saltus/app/new_project.hpp"
#include "saltus/app/plot_verb.hpp"
#include "saltus/app/program.hpp"

int main(int argc, char** argv) {
  std::vector<saltus::ProblemEntry> problems{saltus::push_recovery::entry(),
                                             saltus::quadruped::entry(), saltus::sway::entry()};
  for (saltus::ProblemEntry& entry : problems) entry.kind = "closed loop";
  problems.push_back(saltus::whole_body::entry());
  problems.back().kind = "optimal control";
  for (saltus::ProblemEntry& entry : saltus::library_problems())
    problems.push_back(std::move(entry));
  const std::vector<saltus::Verb> verbs{
      saltus::push_recovery::map_verb(),
      saltus::push_recovery::robot_verb(),
      saltus::push_recovery::control_verb(),
      saltus::robots::walking::movie_verb(),
      saltus::plot_verb(),
      saltus::view_verb(),
      saltus::logs_verb(),
      saltus::suite_verb(),
      saltus::check_verb(),
      saltus::new_verb(),
      saltus::verb_of_program(
          "bench", "compares solvers on the same problems, measures times, runs campaigns",
          "saltus-bench")};
  return saltus::saltus_main(argc, argv, problems, verbs);
}
