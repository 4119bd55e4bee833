// With L = cost + lambda' (rows - bounds) + z' (w - bounds), the derivative of the optimal cost
// with respect to an active bound is -lambda or -z. For scaled variables it is divided by their
// nominal magnitude.
#include "saltus/transcription/multipliers.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace saltus {

namespace {

using shooting::IntervalInstance, shooting::LimitInstance, shooting::RowInstance;

enum class Kind { term, limit, total_time, state, input, costate };

class Collector {
 public:
  Collector(const ShootingProgram& program, const NlpPoint& point)
      : program_(program), point_(point) {}

  // Adds a value to the multipliers of row `row` of item `item`. make_name() returns the name.
  template <class Name>
  void add(Kind kind, int phase, int item, int row, double time, double value, Name&& make_name) {
    const auto [place, is_new] =
        index_.try_emplace({kind, phase, item, row}, static_cast<int>(all_.size()));
    if (is_new)
      all_.push_back(
          {phase < 0 ? "" : program_.problem().phases()[phase].name, make_name(), row, {}, {}});
    Solution::Multiplier& curve = all_[place->second];
    curve.times.push_back(time);
    curve.values.push_back(value);
  }
  double of_row(int row) const { return -point_.lambda[row]; }

  void add_terms() {
    for (const RowInstance& instance : program_.row_instances()) {
      const Term& term = program_.problem().phases()[instance.phase].terms[instance.term];
      for (int i = 0; i < term.function.outputs(); ++i)
        add(Kind::term, instance.phase, instance.term, i,
            program_.time_of(instance.block.point, &point_.w), of_row(instance.first_row + i),
            [&] { return term.name; });
    }
    int item = 0;
    for (const LimitInstance& instance : program_.limit_instances()) {
      const PhaseDefinition& phase = program_.problem().phases()[instance.phase];
      for (int i = 0; i < instance.count; ++i)
        add(Kind::limit, instance.phase, item, i, program_.time_of(instance.point, &point_.w),
            of_row(instance.first_row + i), [&] {
              return instance.link >= 0 ? program_.problem().links()[instance.link].name
                                        : phase.integrals[instance.integral].name;
            });
      ++item;
    }
    if (const int row = program_.total_time_row(); row >= 0) {
      const int last = program_.grid().phases() - 1;
      add(Kind::total_time, -1, 0, 0,
          program_.start_of(last, &point_.w) + program_.duration_of(last, &point_.w), of_row(row),
          [] { return std::string("total time"); });
    }
  }

  void add_bound(Kind kind, int j, int i, double time, int variable, double nominal) {
    if (std::isfinite(program_.lower()[variable]) || std::isfinite(program_.upper()[variable]))
      add(kind, j, i, 0, time, -point_.z[variable] / nominal, [&] {
        return fmt::format("bounds of {} {}", kind == Kind::state ? "state" : "input", i);
      });
  }

  void add_bounds(int j) {
    const PhaseDefinition& phase = program_.problem().phases()[j];
    const int nu = phase.sizes.nu, nc = program_.integrators()[j]->arguments().nc;
    for (int k = 0; k <= program_.grid().intervals(j); ++k)
      for (int i = 0; i < phase.sizes.nx; ++i)
        add_bound(Kind::state, j, i, time_of(j, k), program_.layout().state(j, k) + i,
                  phase.nominal_state[i]);
    for (int k = 0; k < program_.grid().intervals(j); ++k)
      for (int i = 0; i < nc; ++i)
        add_bound(Kind::input, j, i % nu, time_of(j, i < nu ? k : k + 1),
                  program_.layout().input(j, k) + i, phase.nominal_input[i % nu]);
  }

  void add_costates(int j) {
    const PhaseDefinition& phase = program_.problem().phases()[j];
    const auto add_state = [&](int node, int first_row) {
      for (int i = 0; i < phase.sizes.nx; ++i)
        add(Kind::costate, j, 0, i, time_of(j, node),
            of_row(first_row + i) / phase.nominal_state[i],
            [] { return std::string(Solution::Multiplier::costate); });
    };
    add_state(0, j == 0 ? program_.start_row() : program_.jump_row(j));
    for (const IntervalInstance& instance : program_.interval_instances())
      if (instance.phase == j) add_state(instance.interval + 1, instance.first_row);
  }

  std::vector<Solution::Multiplier> collect() {
    add_terms();
    for (int j = 0; j < program_.grid().phases(); ++j) {
      add_bounds(j);
      add_costates(j);
    }
    return std::move(all_);
  }

 private:
  double time_of(int phase, int node) const {
    return program_.time_of({.phase = phase, .node = node}, &point_.w);
  }

  const ShootingProgram& program_;
  const NlpPoint& point_;
  std::vector<Solution::Multiplier> all_;
  std::map<std::tuple<Kind, int, int, int>, int> index_;
};

}  // namespace

std::vector<Solution::Multiplier> multipliers_of(const ShootingProgram& program,
                                                 const NlpPoint& point) {
  if (point.w.size() != program.variables() || point.lambda.size() != program.rows() ||
      point.z.size() != program.variables())
    return {};
  return Collector(program, point).collect();
}

}  // namespace saltus
