#include "saltus/robots/walking/push.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <sstream>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus::robots::walking {

namespace {

Vec<double, 3> towards(double radians) { return {std::cos(radians), std::sin(radians), 0.0}; }

// "TIME IMPULSE ANGLE [DURATION]".
Push read_push(const std::string& text, const Push& pattern) {
  std::istringstream words(text);
  std::vector<double> numbers;
  std::string word;
  bool is_good = true;
  while (words >> word) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    is_good = is_good && *end == '\0' && std::isfinite(numbers.back());
  }
  if (!is_good || numbers.size() < 3 || numbers.size() > 4)
    throw InputError(
        fmt::format("pushes: \"{}\" is not a push; write \"TIME IMPULSE ANGLE [DURATION]\" "
                    "(s, N s, degrees, s), several separated by ';'",
                    shortened(text)));
  Push push = pattern;
  push.start = numbers[0];
  push.impulse = numbers[1];
  push.direction = towards(numbers[2] * std::numbers::pi / 180.0);
  if (numbers.size() == 4) push.duration = numbers[3];
  if (!(push.start >= 0.0 && push.start <= 600.0 && push.impulse >= 0.0 && push.impulse <= 1e4 &&
        std::abs(numbers[2]) <= 3600.0 && push.duration >= 1e-4 && push.duration <= 60.0))
    throw InputError(
        fmt::format("pushes: \"{}\" must have its time within 0 to 600 s, its impulse within 0 to "
                    "10000 N s, its angle within -3600 to 3600 degrees and "
                    "its duration within 0.0001 to 60 s",
                    shortened(text)));
  return push;
}

// Random starts with the requested minimum distance, otherwise uniform: the remaining time is
// divided by sorted random numbers.
std::vector<Push> random_pushes(const Push& pattern, const MorePushes& more) {
  const int count = static_cast<int>(std::lround(more.rate * more.until));
  const double room = more.until - pattern.start - pattern.duration - (count - 1) * more.apart;
  if (count < 1 || room < 0.0)
    throw InputError(fmt::format(
        "push.random.rate_hz ({} Hz) requires {} pushes from {} s (push.start) to {} s, "
        "at least {} s apart, which is impossible; change push.random.rate_hz, "
        "push.random.until_s or push.random.apart_s",
        more.rate, count, pattern.start, more.until, more.apart));
  std::mt19937 random(static_cast<unsigned>(more.seed));
  // The distributions of the standard library differ between platforms.
  const auto uniform = [&random](double from, double to) {
    return from + (to - from) * (static_cast<double>(random()) / 4294967296.0);
  };
  std::vector<double> begins;
  for (int i = 0; i < count; ++i) begins.push_back(uniform(0.0, room));
  std::sort(begins.begin(), begins.end());
  std::vector<Push> pushes;
  for (int i = 0; i < count; ++i) {
    Push push = pattern;
    push.start += begins[static_cast<std::size_t>(i)] + i * more.apart;
    push.impulse = uniform(more.impulse[0], more.impulse[1]);
    push.direction = towards(uniform(-std::numbers::pi, std::numbers::pi));
    pushes.push_back(push);
  }
  return pushes;
}

}  // namespace

std::vector<Push> all_pushes(const Push& first, const MorePushes& more) {
  std::vector<Push> pushes =
      more.rate > 0.0 ? random_pushes(first, more) : std::vector<Push>{first};
  std::istringstream list(more.list);
  for (std::string text; std::getline(list, text, ';');)
    if (text.find_first_not_of(" \t\n") != std::string::npos)
      pushes.push_back(read_push(text, first));
  // Zero impulse means that there is no first push.
  const Push none = pushes.front();
  std::erase_if(pushes, [](const Push& push) { return push.impulse == 0.0; });
  if (pushes.empty()) pushes.push_back(none);
  std::stable_sort(pushes.begin(), pushes.end(),
                   [](const Push& a, const Push& b) { return a.start < b.start; });
  for (std::size_t i = 1; i < pushes.size(); ++i)
    if (pushes[i].start < pushes[i - 1].end() - same_instant)
      throw InputError(
          fmt::format("pushes: the push at {} s begins before the push at {} s ends, at {:.6g} s; "
                      "move it, or shorten one of them",
                      pushes[i].start, pushes[i - 1].start, pushes[i - 1].end()));
  return pushes;
}

}  // namespace saltus::robots::walking
