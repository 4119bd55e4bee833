#include "benchmarks/against.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "benchmarks/data_file.hpp"
#include "benchmarks/hpipm.hpp"
#include "benchmarks/point_shift.hpp"
#include "benchmarks/recorded_sequence.hpp"
#include "benchmarks/step_recovery_batches.hpp"
#include "benchmarks/step_recovery_kernels.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus::bench {
namespace {

namespace fs = std::filesystem;

constexpr int turns = 5;
// Tolerances for HPIPM, the loosest first.
constexpr std::array asked_tolerances{accepted_residual, 0.1 * accepted_residual};
const std::string run_time_sizes = ",run-time-sizes", warm_name = "sequence/warm";

// The minimum time of alternating solves.
struct Least {
  double microseconds = std::numeric_limits<double>::infinity();
  template <class Work>
  void time(const Work& work) {
    const double begin = thread_microseconds();
    work();
    microseconds = std::min(microseconds, thread_microseconds() - begin);
  }
};

qp::QpResult as_result(const Hpipm& solver, const qp::StageQp::Residual& residual) {
  qp::QpResult result;
  result.iterations = solver.iterations();
  result.residual = residual.largest();
  // Only the judge decides; the status of the solver is ignored.
  result.status = qp::QpStatus::optimal;
  return result;
}

class Counter {
 public:
  explicit Counter(const std::string& name) : ours_(name), theirs_("hpipm " + name) {}
  void count(const qp::StageQp& qp, const Least& our_time, const qp::QpResult& our_result,
             const qp::StagePoint& our_point, const Least& their_time, const Hpipm& solver,
             const qp::StagePoint& their_point, int instance) {
    const qp::StageQp::Residual their_residual = kkt_residual(qp, their_point);
    ours_.count(our_time.microseconds, our_result, kkt_residual(qp, our_point).largest(), instance);
    theirs_.count(their_time.microseconds, as_result(solver, their_residual),
                  their_residual.largest(), instance);
    ratios_.push_back(our_time.microseconds / their_time.microseconds);
  }
  Duel duel() const { return {ours_.result(), theirs_.result(), spread(ratios_).median}; }

 private:
  Measurement ours_, theirs_;
  std::vector<double> ratios_;
};

// The loosest tolerance with which the judge accepts some instances; not timed.
double tolerance_for(const HpipmLibrary& library, const Batch& batch, HpipmMode mode) {
  constexpr int instances = 10;
  for (const double tolerance : asked_tolerances) {
    Hpipm solver(library, step_recovery_qp(batch.options, nominal_start()), mode, tolerance);
    bool accepted = true;
    for (int seed = 1; seed <= instances && accepted; ++seed) {
      const qp::StageQp qp = step_recovery_qp(batch.options, random_start(seed, batch.push));
      qp::StagePoint point(qp);
      solver.load(qp);
      solver.solve();
      solver.read(qp, point);
      accepted = kkt_residual(qp, point).largest() <= accepted_residual;
    }
    if (accepted) return tolerance;
  }
  return asked_tolerances.back();
}

Duel cold(const HpipmLibrary& library, const Batch& batch, bool fixed_sizes, int solves) {
  const qp::StageQp capacity = step_recovery_qp(batch.options, nominal_start());
  const auto ours = qp::make_riccati_solver(
      capacity, from_standing(),
      fixed_sizes ? std::span<const qp::RiccatiKernel>(step_recovery_kernels)
                  : std::span<const qp::RiccatiKernel>());
  // With active rows its fast mode misses most instances.
  const HpipmMode mode = batch.name == "recipe/binding" ? HpipmMode::balance : HpipmMode::speed;
  Hpipm theirs(library, capacity, mode, tolerance_for(library, batch, mode));
  Counter counter(batch.name + (fixed_sizes ? "" : run_time_sizes));
  for (int seed = 1; seed <= solves; ++seed) {
    const qp::StageQp qp = step_recovery_qp(batch.options, random_start(seed, batch.push));
    const qp::StagePoint guess = standing_guess(qp);
    qp::StagePoint our_point = guess, their_point(qp);
    theirs.load(qp);
    qp::QpResult result;
    Least our_time, their_time;
    for (int turn = 0; turn < turns; ++turn) {
      our_point = guess;
      our_time.time([&] { result = ours->solve(qp, our_point, /*warm=*/false); });
      their_time.time([&] { theirs.solve(); });
    }
    theirs.read(qp, their_point);
    counter.count(qp, our_time, result, our_point, their_time, theirs, their_point, seed);
  }
  return counter.duel();
}

// Both start from our solution of the previous tick.
Duel warm_from(const HpipmLibrary& library, const RecordedSequence& sequence, Hpipm::Start start,
               double tolerance) {
  const int ticks = static_cast<int>(sequence.problems.size());
  const qp::StageQp capacity = step_recovery_qp({sequence.intervals, 0}, nominal_start());
  const auto ours = qp::make_riccati_solver(capacity, from_standing(), step_recovery_kernels);
  qp::StagePoint point(capacity), shifted(capacity), solved(capacity);
  Counter counter(warm_name);
  qp::StageQp before = sequence.program(0);
  const qp::StagePoint first = standing_guess(before);
  for (std::size_t k = 0; k < first.stages.size(); ++k)
    point.stages[k].u.head(first.stages[k].u.size()) = first.stages[k].u;
  ours->solve(before, point, /*warm=*/false);
  for (int tick = 1; tick < ticks; ++tick) {
    qp::StageQp qp = sequence.program(tick);
    shift_by_one_stage(before, point, qp, standing_guess(qp), shifted);
    Hpipm theirs(library, qp, HpipmMode::speed, tolerance);
    theirs.load(qp);
    qp::QpResult result;
    Least our_time, their_time;
    for (int turn = 0; turn < turns; ++turn) {
      solved = shifted;
      our_time.time([&] { result = ours->solve(qp, solved, /*warm=*/true); });
      theirs.start_at(qp, shifted);
      their_time.time([&] { theirs.solve(start); });
    }
    qp::StagePoint their_point(capacity);
    theirs.read(qp, their_point);
    counter.count(qp, our_time, result, solved, their_time, theirs, their_point, tick);
    point = solved;
    before = std::move(qp);
  }
  return counter.duel();
}

// HPIPM uses the best of its three starts: the fastest of those that miss no tick.
Duel warm(const HpipmLibrary& library) {
  const RecordedSequence sequence = read_sequence(data_file("step_recovery_sequence.json"));
  std::vector<Hpipm::Start> starts{Hpipm::Start::own, Hpipm::Start::primal};
  if (Hpipm(library, sequence.program(0), HpipmMode::speed, accepted_residual).takes_multipliers())
    starts.push_back(Hpipm::Start::primal_and_dual);
  const auto has_reached = [](const Duel& duel) { return duel.theirs.failures.empty(); };
  std::optional<Duel> best;
  for (const Hpipm::Start start : starts)
    for (const double tolerance : asked_tolerances) {
      const Duel duel = warm_from(library, sequence, start, tolerance);
      if (!best ||
          std::pair(has_reached(duel), duel.ratio) > std::pair(has_reached(*best), best->ratio))
        best = duel;
      if (has_reached(duel)) break;
    }
  return *best;
}

}  // namespace

fs::path hpipm_library(const std::optional<fs::path>& given) {
  if (given) return *given;
  std::vector<fs::path> folders{program_folder() / "peers"};
  try {
    folders.push_back(cache_folder() / "peers");
  } catch (const InputError&) {  // without a home folder there is none
  }
  for (const fs::path& folder : folders) {
    fs::path file = folder / "acados/acados/install/lib/libhpipm.so";
    if (fs::exists(file)) return file;
  }
  throw InputError(
      "HPIPM is missing: give its shared library with --library FILE, or install the package "
      "comma-deps-acados with the other peers");
}

std::vector<Duel> measure_against_hpipm(const fs::path& library, const Selection& selection,
                                        const std::function<void(const Duel&)>& observe) {
  const HpipmLibrary hpipm(library);
  std::vector<Duel> duels;
  std::vector<std::string> names;
  const auto run = [&](const std::string& name, const auto& measure) {
    names.push_back(name);
    if (!selection.wants(name)) return;
    duels.push_back(measure());
    if (observe) observe(duels.back());
  };
  for (const Batch& batch : step_recovery_batches()) {
    const int stages = std::max(1, batch.options.intervals / 15);
    const int solves = std::max(3, selection.solves / (10 * stages));
    run(batch.name, [&] { return cold(hpipm, batch, true, solves); });
    if (batch.with_run_time_sizes || batch.options.intervals == 150)
      run(batch.name + run_time_sizes, [&] { return cold(hpipm, batch, false, solves); });
  }
  run(warm_name, [&] { return warm(hpipm); });
  if (duels.empty())
    throw InputError(fmt::format("no case has '{}' in its name; the cases are {}", selection.only,
                                 join_names(names)));
  return duels;
}

std::string duel_head() {
  return fmt::format("{:<28} {:>4} {:>7}   {:>9} {:>6} {:>8} {:>6}   {:>9} {:>6} {:>8} {:>6}\n",
                     "case", "n", "ratio", "ours us", "it", "KKT", "failed", "HPIPM us", "it",
                     "KKT", "failed");
}

std::string duel_line(const Duel& d) {
  const auto side = [](const CaseResult& r) {
    return fmt::format("{:>9.1f} {:>6.2f} {:>8.1e} {:>6}", r.microseconds.median, r.iterations_mean,
                       r.kkt_max, r.failures.size());
  };
  return fmt::format("{:<28} {:>4} {:>7.3f}   {}   {}\n", d.ours.name, d.ours.n, d.ratio,
                     side(d.ours), side(d.theirs));
}

}  // namespace saltus::bench
