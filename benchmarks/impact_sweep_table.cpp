// Prints cost and first input over the time of the impact as CSV.
//
//   impact_sweep [STEP_MS] > sweep.csv
//
// One line per variant, placement of the event and impact time, in steps of STEP_MS (0.1 if
// absent). The largest changes between neighbours go to the error stream. python3 -m
// saltus.walking.plot_sweep draws the file.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <vector>

#include "benchmarks/impact_sweep.hpp"

namespace {

using namespace saltus;
using namespace saltus::push_recovery;

// Returns false if a solve failed.
bool sweep(const SweepVariant& variant, double step, bool rounded) {
  ImpactSweep problem(variant);
  std::vector<SweepPoint> points;
  int failures = 0, iterations = 0;
  double kkt = 0.0;
  for (const double t : sweep_times(step)) {
    points.push_back(rounded ? problem.solve_rounded(t) : problem.solve(t));
    const SweepPoint& p = points.back();
    failures += is_success(p.status) ? 0 : 1;
    iterations += p.iterations;
    kkt = std::max(kkt, p.kkt);
    fmt::print("{:g},{},{},{:g},{},{:.6f},{:.10g}", 1e3 * variant.step, variant.intervals,
               variant.cost_rule == CostRule::nodes ? "nodes" : "integrated", variant.wrench_change,
               rounded ? "rounded" : "exact", 1e3 * t, p.cost);
    for (const double u : p.first_input) fmt::print(",{:.8g}", u);
    fmt::print("\n");
  }
  const Change change = largest_change(points);
  fmt::print(stderr,
             "{:<48} {:<8} largest change in {:g} ms: cost {:.5f}, first input {:.4f}; {} solves, "
             "{} failed, {:.1f} iterations, KKT {:.0e}\n",
             variant.name(), rounded ? "rounded" : "exact", 1e3 * step, change.cost, change.input,
             points.size(), failures, static_cast<double>(iterations) / points.size(), kkt);
  return failures == 0;
}

}  // namespace

int main(int argc, char** argv) {
  double step_ms = 0.1;
  if (argc > 1) {
    const std::string_view text = argv[1];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), step_ms);
    if (argc > 2 || error != std::errc() || end != text.data() + text.size() ||
        !(step_ms > 0.0 && step_ms <= 70.0)) {
      fmt::print(stderr, "usage: impact_sweep [STEP_MS], the step above 0 and at most 70 ms\n");
      return 2;
    }
  }
  fmt::print("dt_ms,intervals,costs,wrench_change,impact,impact_ms,cost");
  for (const char* foot : {"left", "right"})
    for (const char* entry : {"fx", "fy", "fz", "tx", "ty", "tz"})
      fmt::print(",{}_{}", foot, entry);
  fmt::print("\n");
  bool solved = true;
  for (const SweepVariant& variant : sweep_variants())
    for (const bool rounded : {false, true})
      solved = sweep(variant, 1e-3 * step_ms, rounded) && solved;
  return solved ? 0 : 3;
}
