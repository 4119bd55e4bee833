#include "saltus/robots/walking/settling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/body_forces.hpp"

namespace saltus::robots::walking {

double settling_time(std::span<const double> times, std::span<const double> values, double begin,
                     double band) {
  if (times.size() != values.size())
    throw DefinitionError(
        fmt::format("settling: {} times and {} values were given, expected equal numbers",
                    times.size(), values.size()));
  if (times.size() < 2) return infinity;
  const double mean_from = times.back() - force_settled_over;
  double sum = 0.0, length = 0.0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const double held = times[i + 1] - std::max(times[i], mean_from);
    if (held <= 0.0) continue;
    sum += held * values[i];
    length += held;
  }
  const double mean = sum / length;
  std::size_t settled = times.size();
  while (settled > 0 && std::abs(values[settled - 1] - mean) <= band) --settled;
  if (settled == times.size() || times[settled] > mean_from + same_instant) return infinity;
  return std::max(0.0, times[settled] - begin);
}

ForceSettling force_settling(const RunLog& log, double from) {
  ForceSettling settling;
  if (log.touchdown == infinity || log.stopped_early) return settling;
  const double band = force_settled_within * log.robot.mass * standard_gravity;
  std::vector<double> times, values(log.samples.size());
  for (const BipedSample& s : log.samples) times.push_back(s.time);
  const bool has_body = !log.body.empty();
  const std::vector<Vec<double, 12>> measured =
      has_body ? filtered_wrenches(log) : std::vector<Vec<double, 12>>{};
  for (int foot = 0; foot < 2; ++foot) {
    const int fz = 6 * foot + 2;
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = has_body ? log.body[i].planned[fz] : log.samples[i].wrenches[fz];
    settling.planned[foot] = settling_time(times, values, from, band);
    if (!has_body) continue;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = measured[i][fz];
    settling.measured[foot] = settling_time(times, values, from, band);
  }
  return settling;
}

nlohmann::ordered_json to_json(const ForceSettling& s) {
  return {{"planned_left_s", s.planned[0]},
          {"planned_right_s", s.planned[1]},
          {"measured_left_s", s.measured[0]},
          {"measured_right_s", s.measured[1]}};
}

}  // namespace saltus::robots::walking
