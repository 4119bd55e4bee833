#include "problems/library/case_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/text.hpp"

namespace saltus {

const char* word_for(Verdict verdict) {
  switch (verdict) {
    case Verdict::met:
      return "ok";
    case Verdict::missed:
      return "MISSED";
    case Verdict::failed:
      return "FAILED";
    case Verdict::skipped:
      return "skipped";
    case Verdict::not_applicable:
      return "n/a";
  }
  return "unknown";
}

std::vector<std::string> CaseOutcome::reasons() const {
  if (verdict != Verdict::missed && verdict != Verdict::met) return {status};
  std::vector<std::string> sentences;
  for (const CheckedValue& v : checked) {
    if (v.is_met()) continue;
    sentences.push_back(v.reference == 0.0 && v.digits == 0
                            ? fmt::format("{} is {:.2e}, but at most {:.1e} is allowed", v.name,
                                          v.value, v.tolerance)
                            : fmt::format("{} is {:.12g} instead of {:.12g}: the error is {:.1e}, "
                                          "but at most {:.1e} is allowed",
                                          v.name, v.value, v.reference, v.error(), v.tolerance));
  }
  return sentences;
}

std::string CaseOutcome::reason_in_brief() const {
  const std::vector<std::string> all = reasons();
  if (all.size() < 2) return all.empty() ? status : all.front();
  std::vector<std::string> others;
  for (const CheckedValue& v : checked)
    if (!v.is_met()) others.push_back(v.name);
  others.erase(others.begin());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  return fmt::format("{}; also outside: {}", all.front(), join_names(others));
}

std::string CaseOutcome::refined_in_words() const {
  if (refinements == 0) return {};
  return fmt::format("refined {}: the first plan violated a path constraint between the nodes",
                     refinements == 1 ? "once" : fmt::format("{} times", refinements));
}

Verdict judge(const std::vector<CheckedValue>& checked) {
  const bool all =
      std::all_of(checked.begin(), checked.end(), [](const CheckedValue& v) { return v.is_met(); });
  return all && !checked.empty() ? Verdict::met : Verdict::missed;
}

void bring_worst_to_front(std::vector<CheckedValue>& checked) {
  const auto worst = std::max_element(
      checked.begin(), checked.end(), [](const CheckedValue& a, const CheckedValue& b) {
        return a.fraction_of_tolerance() < b.fraction_of_tolerance();
      });
  if (worst != checked.end()) std::rotate(checked.begin(), worst, std::next(worst));
}

}  // namespace saltus
