// Program for the demo and the survival map: `saltus` without the library of reference problems.
#include <vector>

#include "problems/biped/report/scripts.hpp"
#include "problems/push_recovery/push_recovery.hpp"
#include "saltus/app/logs_verb.hpp"
#include "saltus/app/new_project.hpp"
#include "saltus/app/plot_verb.hpp"
#include "saltus/app/program.hpp"

int main(int argc, char** argv) {
  const std::vector<saltus::ProblemEntry> problems{saltus::push_recovery::entry()};
  const std::vector<saltus::Verb> verbs{saltus::push_recovery::map_verb(),
                                        saltus::push_recovery::robot_verb(),
                                        saltus::push_recovery::control_verb(),
                                        saltus::robots::walking::movie_verb(),
                                        saltus::plot_verb(),
                                        saltus::view_verb(),
                                        saltus::logs_verb(),
                                        saltus::new_verb()};
  return saltus::saltus_main(argc, argv, problems, verbs);
}
