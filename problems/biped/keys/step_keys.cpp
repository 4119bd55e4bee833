#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <string>

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {

void declare_stepping(Settings& s, Step& step) { s.flag("stepping", step.allowed, "allow steps"); }

void declare_settings(Settings& s, Step& step) {
  s.number("step.duration", step.duration, "s",
           "time from the trigger to the landing; with step.planner=reactive the maximum",
           between(0.01, 60.0));
  s.choice<Step::Decision>(
      "step.decide", step.decide,
      {{"always", Step::Decision::always}, {"if_it_helps", Step::Decision::if_it_helps}},
      "when to step after the capture point has left the sole: always, or only if the step brings "
      "the support closer to it");
  s.number("step.decision_lead_s", step.decision_lead, "s",
           "if given, the landing place follows the capture point until this long before the "
           "landing; none: it is fixed 0.1 s after the trigger",
           at_least(0.0));
  s.choice<Step::Placement>(
      "step.placement", step.placement,
      {{"predicted", Step::Placement::predicted}, {"fixed", Step::Placement::fixed}},
      "landing place: the predicted capture point, or step.fixed_place");
  s.vector(
      "step.fixed_place", step.fixed_place, "m",
      "position of the swing sole relative to the stance sole: forward, and sideways away from it");
  s.rule({"step.fixed_place"}, [&step] {
    return step.fixed_place[1] > 0.0 ? ""
                                     : fmt::format(
                                           "step.fixed_place points away from the stance sole, on "
                                           "either side: its second entry must be positive, not {}",
                                           step.fixed_place[1]);
  });
  s.number("step.lateral_min", step.lateral_min, "m", "minimum lateral distance of the soles",
           above(0.0));
  s.number("step.lateral_max", step.lateral_max, "m", "maximum lateral distance of the soles",
           above(0.0));
  s.number("step.forward_max", step.forward_max, "m",
           "maximum length of a step, forward and backward", at_least(0.0));
  s.rule({"step.lateral_min", "step.lateral_max"}, [&step] {
    return step.lateral_min <= step.lateral_max
               ? ""
               : fmt::format("step.lateral_min ({}) exceeds step.lateral_max ({})",
                             step.lateral_min, step.lateral_max);
  });
}

}  // namespace saltus::robots::walking
