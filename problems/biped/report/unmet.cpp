#include "problems/biped/report/unmet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "saltus/simulation/explanation_json.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

std::string head(const UnmetDecision& unmet) {
  const std::string missed =
      unmet.missed < infinity
          ? fmt::format("violated its soft limit by {:.1f} mm", 1e3 * unmet.missed)
          : std::string("found no plan");
  return fmt::format("the program of {} {} at t = {:.4g} s:\n", unmet.decision, missed, unmet.time);
}

// Writes the sentences of Explanation::text(), with the problem's own wording if it defines one.
class Teller {
 public:
  Teller(const UnmetExplanations& words, const UnmetDecision& unmet, const Explanation& explanation)
      : words_(words), unmet_(unmet), explanation_(explanation) {}

  std::string text() const {
    if (!explanation_.ok()) return "  " + explanation_.text();
    std::string text;
    for (const Explanation::Shortage& s : explanation_.shortages)
      text += "  " + of(s, s.text()) + "\n";
    for (const Explanation::SoftShortage& s : explanation_.gives_way)
      text += fmt::format("  {}\n    {}\n", of(s.missed, s.text()), why(s));
    if (text.empty()) text = "  the constraints can be met near the guess\n";
    const char* lead = "it could be met ";
    for (const Explanation::Remedy& remedy : explanation_.remedies) {
      text += fmt::format("  {}{}\n", lead, of(remedy));
      lead = "             or ";
    }
    return text;
  }

 private:
  std::string of(const Explanation::Shortage& s, const std::string& general) const {
    const std::string own = words_.of(unmet_, s);
    return own.empty() ? general : own;
  }
  std::string of(const Explanation::Remedy& remedy) const {
    std::vector<std::string> clauses;  // skip repeated rows of a hull
    for (const ProblemChange& change : remedy.changes) {
      std::string own = words_.of(unmet_, change);
      if (own.empty()) return remedy.text;
      if (std::ranges::find(clauses, own) == clauses.end()) clauses.push_back(std::move(own));
    }
    return fmt::format("{}", fmt::join(clauses, " and "));
  }
  std::string why(const Explanation::SoftShortage& s) const {
    const std::string limits = words_.limits(unmet_);
    const std::string within = limits.empty() ? "" : " " + limits;
    if (!s.least) return fmt::format("it is unknown whether it could be met{}", within);
    if (*s.least > 0.0)
      return fmt::format("it cannot be met{}: at least {:.1f} mm are missing", within,
                         1e3 * *s.least);
    if (!s.cost_if_held) return fmt::format("it could be met{}", within);
    return fmt::format(
        "it could be met{}, at an additional cost of {:.4g}{}", within,
        *s.cost_if_held - explanation_.cost,
        explanation_.gives_way_to.empty() ? "" : ", mostly of " + explanation_.gives_way_to);
  }

  const UnmetExplanations& words_;
  const UnmetDecision& unmet_;
  const Explanation& explanation_;
};

Explanation explained(const UnmetExplanations& words, const UnmetDecision& unmet,
                      double time_limit) {
  return explain(words.problem(unmet), {.shooting = unmet.shooting,
                                        .time_limit = time_limit,
                                        .may_change = [&](const ProblemChange& change) {
                                          return words.may_change(unmet, change);
                                        }});
}

}  // namespace

UnmetReport explain_unmet(const UnmetExplanations& words, const std::vector<UnmetDecision>& unmet,
                          double time_limit) {
  UnmetReport report{Json::array(), {}};
  for (const UnmetDecision& decision : unmet) {
    Json json = {{"decision", decision.decision},
                 {"t_s", decision.time},
                 {"missed_m", decision.missed}};  // null without a plan
    report.text += head(decision);
    if (time_limit > 0.0) {
      const Explanation explanation = explained(words, decision, time_limit);
      const std::string text = Teller(words, decision, explanation).text();
      json["text"] = head(decision) + text;
      json["explanation"] = Json::parse(explanation_json(explanation));
      report.text += text;
    }
    report.json.push_back(std::move(json));
  }
  return report;
}

}  // namespace saltus::robots::walking
