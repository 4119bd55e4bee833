#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <string>

#include "saltus/app/settings.hpp"
#include "saltus/robots/walking/push.hpp"

namespace saltus::walking {

void declare_settings(Settings& s, Push& push) {
  s.number("push.impulse", push.impulse, "N s", "size of the push", between(0.0, 1e4));
  s.vector("push.direction", push.direction, "", "direction of the push, world axes",
           between(-1e6, 1e6));
  s.number("push.duration", push.duration, "s", "how long it lasts", between(1e-4, 60.0));
  s.number("push.start", push.start, "s", "when it begins", between(0.0, 600.0));
  s.choice<PulseShape>("push.shape", push.shape,
                       {{describe(PulseShape::rectangle), PulseShape::rectangle},
                        {describe(PulseShape::half_sine), PulseShape::half_sine},
                        {describe(PulseShape::triangle), PulseShape::triangle}},
                       "of the force over time; the impulse is the same");
  s.rule({"push.direction"}, [&push] {
    return push.direction.norm() >= 1e-6 ? "" : "push.direction must not be zero, nor near it";
  });
}

void declare_settings(Settings& s, MorePushes& more, const Push& first) {
  s.text(
      "pushes", more.list,
      "further pushes: \"TIME IMPULSE ANGLE [DURATION]; ...\" (s, N s, degrees: 0 forward, 90 to "
      "the left, s)");
  s.number("push.random.rate_hz", more.rate, "Hz",
           "pushes in random directions in place of the first one, from push.start on; 0: none",
           between(0.0, 100.0));
  s.number("push.random.until_s", more.until, "s", "they are over by then", between(0.0, 600.0));
  s.vector("push.random.impulse", more.impulse, "N s", "their sizes, from and to",
           between(0.0, 1e4));
  s.number("push.random.apart_s", more.apart, "s", "from begin to begin at least", at_least(0.0));
  s.integer("push.random.seed", more.seed, "", "which ones", at_least(0.0));
  s.rule({"push.random.impulse"}, [&more] {
    return more.impulse[0] <= more.impulse[1]
               ? ""
               : fmt::format(
                     "push.random.impulse goes from {} to {}; the first must not exceed the "
                     "second",
                     more.impulse[0], more.impulse[1]);
  });
  s.rule({"pushes", "push.start", "push.duration", "push.random.rate_hz", "push.random.until_s",
          "push.random.apart_s"},
         [&more, &first]() -> std::string {
           try {
             all_pushes(first, more);
             return {};
           } catch (const InputError& error) {
             return error.what();
           }
         });
}

void declare_point_of_push(Settings& s, Push& push) {
  s.text("push.link", push.link, "whole body: the link that is pushed (the centroidal model: CoM)");
  s.vector("push.point", push.point, "m", "whole body: where on that link, in its frame",
           between(-10.0, 10.0));
}

}  // namespace saltus::walking
