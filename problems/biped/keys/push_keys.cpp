#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <string>

#include "saltus/app/settings.hpp"
#include "saltus/robots/walking/push.hpp"

namespace saltus::robots::walking {

void declare_settings(Settings& s, Push& push) {
  s.number("push.impulse", push.impulse, "N s", "impulse of the push", between(0.0, 1e4));
  s.vector("push.direction", push.direction, "", "direction of the push, in world axes",
           between(-1e6, 1e6));
  s.number("push.duration", push.duration, "s", "duration of the push", between(1e-4, 60.0));
  s.number("push.start", push.start, "s", "start of the push", between(0.0, 600.0));
  s.choice<PulseShape>("push.shape", push.shape,
                       {{describe(PulseShape::rectangle), PulseShape::rectangle},
                        {describe(PulseShape::half_sine), PulseShape::half_sine},
                        {describe(PulseShape::triangle), PulseShape::triangle}},
                       "shape of the force over time; the impulse is the same");
  s.rule({"push.direction"}, [&push] {
    return push.direction.norm() >= 1e-6 ? "" : "push.direction must not be zero or almost zero";
  });
}

void declare_settings(Settings& s, MorePushes& more, const Push& first) {
  s.text(
      "pushes", more.list,
      "further pushes: \"TIME IMPULSE ANGLE [DURATION]; ...\" (s, N s, degrees: 0 forward, 90 to "
      "the left, s)");
  s.number("push.random.rate_hz", more.rate, "Hz",
           "rate of random pushes in random directions, which replace the first push, from "
           "push.start on; 0: none",
           between(0.0, 100.0));
  s.number("push.random.until_s", more.until, "s", "end of the random pushes", between(0.0, 600.0));
  s.vector("push.random.impulse", more.impulse, "N s",
           "smallest and largest impulse of the random pushes", between(0.0, 1e4));
  s.number("push.random.apart_s", more.apart, "s",
           "minimum time between the starts of two random pushes", at_least(0.0));
  s.integer("push.random.seed", more.seed, "", "seed of the random pushes", at_least(0.0));
  s.rule({"push.random.impulse"}, [&more] {
    return more.impulse[0] <= more.impulse[1]
               ? ""
               : fmt::format(
                     "push.random.impulse is [{}, {}]; the first entry must not exceed the second",
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
  s.text("push.link", push.link,
         "whole body: link that is pushed (the centroidal model is pushed at its CoM)");
  s.vector("push.point", push.point, "m",
           "whole body: point of application on this link, in its frame", between(-10.0, 10.0));
}

}  // namespace saltus::robots::walking
