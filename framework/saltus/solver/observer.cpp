#include "saltus/solver/solver.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace saltus {
namespace {

std::string number_or_dash(const char* format, double value) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

}  // namespace

SolveObserver with_cost_times(const SolveObserver& observer, double factor) {
  SolveObserver result = observer;
  if (observer.report && factor != 1.0)
    result.report = [report = observer.report, factor](SolveObserver::Iteration it) {
      if (!it.is_restoring) it.cost *= factor;
      report(it);
    };
  return result;
}

std::string header_of_iterations() {
  return fmt::format("{:>5} {:>14} {:>9} {:>9} {:>6} {:>9} {:>8} {:>8} {:>8}", "iter", "cost",
                     "violation", "gradient", "lg(mu)", "step", "shift", "dual", "primal");
}

std::string row_of_iterations(const SolveObserver::Iteration& it) {
  const double lg_barrier = it.barrier > 0.0 ? std::log10(it.barrier) : std::nan("");
  return fmt::format(
      "{:>4}{} {:>14.7e} {:>9.2e} {:>9.2e} {:>6} {:>9.2e} {:>8} {:>8} {:>8.2e}", it.number,
      it.is_restoring ? 'r' : ' ', it.cost, it.violation, it.stationarity,
      number_or_dash("{:.1f}", lg_barrier), it.step,
      number_or_dash("{:.1e}", it.regularisation > 0.0 ? it.regularisation : std::nan("")),
      number_or_dash("{:.2e}", it.dual_step_length), it.step_length);
}

std::function<void(const SolveObserver::Iteration&)> table_of_iterations(
    std::function<void(const std::string& line)> print, int header_every) {
  return [print = std::move(print), header_every,
          rows = 0](const SolveObserver::Iteration& it) mutable {
    if (rows++ % header_every == 0) print(header_of_iterations());
    print(row_of_iterations(it));
  };
}

}  // namespace saltus
