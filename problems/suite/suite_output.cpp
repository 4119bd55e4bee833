#include "problems/suite/suite_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace saltus {
namespace {

constexpr const char* row = "{:<26} {:>20} {:>20} {:>8} {:>6} {:>8} {:>4} {:>7} {:<7} {}\n";

// Number with all known digits, at most 14.
std::string number(double value, int digits) {
  return fmt::format("{:.{}g}", value, digits > 0 ? std::min(digits, 14) : 6);
}

}  // namespace

std::string table_head() {
  return fmt::format(row, "case", "value", "reference", "error", "digits", "between", "it",
                     "time s", "status", "exercises");
}

std::string table_line(const CaseOutcome& o) {
  std::string value = "-", reference = "-", error = "-", digits = "-", what = o.exercises;
  std::string between = "-";
  if (o.between_nodes)
    between = *o.between_nodes > 0.0 ? fmt::format("{:.0e}", *o.between_nodes) : "0";
  if (!o.checked.empty()) {
    const CheckedValue& shown = o.checked.front();
    value = number(shown.value, shown.digits);
    reference = number(shown.reference, shown.digits);
    error = fmt::format("{:.1e}", shown.relative_error());
    if (shown.name != "cost") what += "; shown: " + shown.name;
    if (o.refinements > 0) what += "; " + o.refined_in_words();
    if (shown.digits > 0) digits = fmt::format("{}/{}", shown.digits_reached(), shown.digits);
  }
  return fmt::format(row, o.id + " " + o.name, value, reference, error, digits, between,
                     o.iterations > 0 ? std::to_string(o.iterations) : "-",
                     fmt::format("{:.3f}", o.seconds), word_for(o.verdict), what);
}

std::string closing_text(const SuiteReport& report) {
  std::string text = "\n";
  for (const CaseOutcome& o : report.outcomes)
    if (o.verdict != Verdict::met)
      text += fmt::format("{} {} {}: {}\n", o.id, o.name, word_for(o.verdict), o.reason_in_brief());
  if (text.size() > 1) text += "\n";
  const int skipped = report.count(Verdict::skipped), idle = report.count(Verdict::not_applicable);
  text += fmt::format("{} of {} within tolerance with solver={}", report.count(Verdict::met),
                      static_cast<int>(report.outcomes.size()) - skipped - idle,
                      name_of(report.solver));
  int missing = 0, simulated = 0;
  for (const CaseOutcome& o : report.outcomes)
    if (o.is_simulation) ++(o.verdict == Verdict::met ? simulated : missing);
  if (simulated + missing > 0)
    text += fmt::format(" (including {} of {} simulations)", simulated, simulated + missing);
  if (skipped > 0) text += fmt::format(", {} skipped", skipped);
  if (idle > 0) text += fmt::format(", {} not applicable to this solver", idle);
  return text + "\n";
}

nlohmann::ordered_json to_json(const SuiteReport& report) {
  using Json = nlohmann::ordered_json;
  const auto digits = [](int known, int figure) { return known > 0 ? Json(figure) : Json(); };
  Json cases = Json::array();
  for (const CaseOutcome& o : report.outcomes) {
    Json checked = Json::array();
    for (const CheckedValue& v : o.checked)
      checked.push_back({{"name", v.name},
                         {"value", v.value},
                         {"reference", v.reference},
                         {"error", v.error()},
                         {"relative_error", v.relative_error()},
                         {"tolerance", v.tolerance},
                         {"digits_reached", digits(v.digits, v.digits_reached())},
                         {"digits_known", digits(v.digits, v.digits)},
                         {"met", v.is_met()}});
    Json reasons = Json::array();
    if (o.verdict != Verdict::met) reasons = o.reasons();
    cases.push_back({{"id", o.id},
                     {"name", o.name},
                     {"exercises", o.exercises},
                     {"source", o.source},
                     {"kind", o.is_simulation ? "simulation" : "optimisation"},
                     {"verdict", word_for(o.verdict)},
                     {"status", o.status},
                     {"iterations", o.iterations},
                     {"refinements", o.refinements},
                     {"seconds", o.seconds},
                     {"between_nodes", o.between_nodes ? Json(*o.between_nodes) : Json()},
                     {"checked", checked},
                     {"reasons", reasons}});
  }
  return {{"solver", name_of(report.solver)},
          {"interrupted", report.was_interrupted},
          {"within_tolerance", report.count(Verdict::met)},
          {"missed", report.count(Verdict::missed)},
          {"failed", report.count(Verdict::failed)},
          {"skipped", report.count(Verdict::skipped)},
          {"not_applicable", report.count(Verdict::not_applicable)},
          {"cases", cases}};
}

}  // namespace saltus
