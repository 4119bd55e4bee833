#include "saltus/solve/explain.hpp"

#include <fmt/format.h>

#include "saltus/transcription/violation.hpp"

namespace saltus {
namespace {

std::string remedies_text(const Explanation& explanation, const char* first) {
  std::string text;
  const std::string next = fmt::format("{:>{}}", "or ", std::string_view(first).size());
  for (const Explanation::Remedy& remedy : explanation.remedies)
    text += (text.empty() ? first : next) + remedy.text + "\n";
  return text;
}

// States whether the term can hold and at what cost; follows its sentence.
std::string why_text(const Explanation::SoftShortage& soft, const Explanation& explanation) {
  if (!soft.least) return "";
  if (*soft.least > 0.0)
    return fmt::format("  it cannot hold: at least {:.4g} is missing\n", *soft.least);
  if (!soft.cost_if_held) return "  it could hold\n";
  std::string text = fmt::format("  it could hold at an additional cost of {:.4g}",
                                 *soft.cost_if_held - explanation.cost);
  if (!explanation.gives_way_to.empty())
    text += fmt::format(", most of it from {}", explanation.gives_way_to);
  if (soft.weight_that_holds)
    text += fmt::format("; a weight of {:.3g} instead of {:.3g} enforces it",
                        *soft.weight_that_holds, soft.weight);
  return text + "\n";
}

}  // namespace

std::string Explanation::Shortage::name() const {
  const std::string place = phase.empty() ? "" : fmt::format("phase '{}', ", phase);
  if (kind == "total time") return term;
  if (kind == "closing") return fmt::format("closing, state {}", component);
  if (kind == "state") return place + "bounds of " + term;
  return fmt::format("{}{} '{}'{}", place, kind, term,
                     component > 0 ? fmt::format(", row {}", component) : "");
}

std::string Explanation::Shortage::miss() const {
  const bool is_low = side == ProblemChange::Side::lower;
  return fmt::format("{:.4g} too {} at t = {:.4g} s ({:.6g} where {}{:.6g} is required)", amount,
                     is_low ? "little" : "much", time, value,
                     is_exact ? ""
                     : is_low ? "at least "
                              : "at most ",
                     bound);
}

std::string Explanation::Shortage::text() const {
  return fmt::format("{} {}: {}", name(),
                     is_certain ? "cannot be met" : "was not met near the guess", miss());
}

std::string Explanation::SoftShortage::text() const {
  return fmt::format("{} is soft and violated: {}, at a cost of {:.4g}", missed.name(),
                     missed.miss(), price);
}

std::string Explanation::text() const {
  if (!ok())
    return fmt::format(
        "the smallest relaxation is unknown: {}{}\n", describe(status),
        status == SolveStatus::evaluation_failed ? "; check(problem) shows where" : "");
  std::string text;
  for (const Explanation::Shortage& shortage : shortages) text += shortage.text() + "\n";
  if (!shortages.empty() && !events_in.empty())
    text += fmt::format("{}\n", saltus::events_hint(events_in));
  if (!shortages.empty()) return text + remedies_text(*this, "it would be feasible ");
  text = gives_way.empty() ? "the constraints can be met near the guess\n"
                           : "the hard constraints can be met near the guess\n";
  for (const Explanation::SoftShortage& soft : gives_way)
    text += soft.text() + "\n" + why_text(soft, *this);
  return text + remedies_text(*this, "it would hold ");
}

}  // namespace saltus
