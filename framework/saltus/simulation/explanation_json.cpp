#include "saltus/simulation/explanation_json.hpp"

#include "saltus/core/json_object.hpp"

namespace saltus {
namespace {

const char* name_of(ProblemChange::Side side) {
  return side == ProblemChange::Side::lower ? "lower" : "upper";
}

JsonObject object_of(const Explanation::Shortage& s) {
  return JsonObject()
      .text("kind", s.kind)
      .text("phase", s.phase)
      .text("term", s.term)
      .integer("component", s.component)
      .text("side", name_of(s.side))
      .number("t_s", s.time)
      .number("amount", s.amount)
      .number("nominal", s.nominal)
      .number("value", s.value)
      .number("bound", s.bound);
}

std::string json_of(const Explanation::Shortage& s) {
  return object_of(s).text("text", s.text()).str();
}

std::string json_of(const Explanation::SoftShortage& s) {
  return object_of(s.missed)
      .number("price", s.price)
      .number("weight", s.weight)
      .number("least", s.least)
      .number("cost_if_held", s.cost_if_held)
      .number("weight_that_holds", s.weight_that_holds)
      .text("text", s.text())
      .str();
}

std::string json_of(const ProblemChange& c) {
  return JsonObject()
      .text("kind", describe(c.kind))
      .integer("phase", c.phase)
      .text("name", c.name)
      .integer("component", c.component)
      .text("side", name_of(c.side))
      .number("by", c.by)
      .str();
}

std::string json_of(const Explanation::Remedy& r) {
  return JsonObject()
      .text("text", r.text)
      .raw("changes", json_list(r.changes, [](const ProblemChange& c) { return json_of(c); }))
      .text("status", describe(r.status))
      .number("cost", r.cost)
      .number("effort", r.effort)
      .str();
}

}  // namespace

std::string explanation_json(const Explanation& explanation) {
  return JsonObject()
      .text("status", describe(explanation.status))
      .number("relaxation", explanation.relaxation)
      .raw("missing", json_list(explanation.shortages,
                                [](const Explanation::Shortage& s) { return json_of(s); }))
      .raw("gives_way", json_list(explanation.gives_way,
                                  [](const Explanation::SoftShortage& s) { return json_of(s); }))
      .text("gives_way_to", explanation.gives_way_to)
      .number("cost", explanation.cost)
      .raw("remedies",
           json_list(explanation.remedies, [](const Explanation::Remedy& r) { return json_of(r); }))
      .number("seconds", explanation.seconds)
      .str();
}

}  // namespace saltus
