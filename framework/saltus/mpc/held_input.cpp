#include "saltus/mpc/receding_horizon.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

HeldInput::HeldInput(int pieces, int largest_input) : pieces_(pieces) {
  for (HeldInput::Piece& piece : pieces_) piece.values = VectorXd::Zero(largest_input);
}

void HeldInput::refuse(std::size_t i) const {
  throw DefinitionError(
      fmt::format("held input: there is no piece {}; it has {} pieces and room for {}",
                  static_cast<std::ptrdiff_t>(i), count_, pieces_.size()));
}

bool HeldInput::all_finite() const {
  return std::all_of(begin(), end(),
                     [](const HeldInput::Piece& p) { return p.input().allFinite(); });
}

HeldInput held_input_for(const MultipleShooting& shooting) {
  int pieces = 1, largest = 0;
  for (int j = 0; j < shooting.grid().phases(); ++j) {
    pieces += shooting.grid().intervals(j);
    largest = std::max(largest, shooting.problem().phases()[j].sizes.nu);
  }
  return {pieces, largest};
}

void hold(const MultipleShooting& shooting, const VectorXd& w, double t, double period,
          HeldInput& held) {
  held.clear();
  const Grid& grid = shooting.grid();
  const Layout& layout = shooting.layout();
  double at = t, start = shooting.data().start_time;
  int last_phase = -1, last_interval = -1;
  const auto add = [&](int j, int k, double length, double fraction) {
    const PhaseDefinition& phase = shooting.problem().phases()[j];
    const int nu = phase.sizes.nu, first = layout.input(j, k);
    const bool linear = phase.input_shape() == InputShape::linear;
    HeldInput::Piece& piece = held.add();
    piece.start = at;
    piece.length = length;
    piece.size = nu;
    for (int i = 0; i < nu; ++i) {
      const double end = linear ? w[first + nu + i] : w[first + i];
      piece.values[i] = ((1.0 - fraction) * w[first + i] + fraction * end) * phase.nominal_input[i];
    }
    at += length;
  };
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = shooting.problem().phases()[j];
    const int d = layout.duration(j);
    const double T = d < 0 ? grid.reference_duration(j) : w[d] * phase.nominal_duration;
    for (int k = 0; k < grid.intervals(j); ++k) {
      const Grid::Interval& interval = grid.interval(j, k);
      if (interval.is_empty()) continue;
      last_phase = j;
      last_interval = k;
      const double begin = start + interval.offset(T), length = interval.length(T);
      const double end = std::min(begin + length, t + period);
      if (end - at <= same_instant) continue;  // the interval or the tick is over
      const double middle = 0.5 * (std::max(at, begin) + end);
      add(j, k, end - at, std::clamp((middle - begin) / length, 0.0, 1.0));
    }
    start += T;
  }
  const double left = t + period - at;
  if (left > same_instant || held.empty()) {
    if (last_interval >= 0) add(last_phase, last_interval, left, 1.0);
  } else {
    held.last().length = t + period - held.last().start;
  }
}

}  // namespace saltus
