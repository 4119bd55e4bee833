#include "saltus/simulation/explanation_json.hpp"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "saltus/simulation/text_table.hpp"

namespace saltus {
namespace {

// Writes a JSON object member by member.
class Object {
 public:
  Object& text(const char* key, std::string_view value) { return raw(key, json_string(value)); }
  Object& number(const char* key, double value) { return raw(key, json_number(value)); }
  Object& number(const char* key, const std::optional<double>& value) {
    return raw(key, value ? json_number(*value) : "null");
  }
  Object& integer(const char* key, int value) { return raw(key, fmt::format("{}", value)); }
  Object& raw(const char* key, const std::string& value) {
    text_ += fmt::format("{}{}: {}", text_.empty() ? "" : ", ", json_string(key), value);
    return *this;
  }
  std::string str() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

template <class Item, class ToJson>
std::string list_of(const std::vector<Item>& items, const ToJson& to_json) {
  std::string list;
  for (const Item& item : items) list += (list.empty() ? "" : ", ") + to_json(item);
  return "[" + list + "]";
}

const char* name_of(ProblemChange::Side side) {
  return side == ProblemChange::Side::lower ? "lower" : "upper";
}

Object object_of(const Shortage& s) {
  Object o;
  return o.text("kind", s.kind)
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

std::string json_of(const Shortage& s) { return object_of(s).text("text", s.text()).str(); }

std::string json_of(const SoftShortage& s) {
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
  Object o;
  return o.text("kind", describe(c.kind))
      .integer("phase", c.phase)
      .text("name", c.name)
      .integer("component", c.component)
      .text("side", name_of(c.side))
      .number("by", c.by)
      .str();
}

std::string json_of(const Remedy& r) {
  Object o;
  return o.text("text", r.text)
      .raw("changes", list_of(r.changes, [](const ProblemChange& c) { return json_of(c); }))
      .text("status", describe(r.status))
      .number("cost", r.cost)
      .number("effort", r.effort)
      .str();
}

}  // namespace

std::string explanation_json(const Explanation& explanation) {
  Object o;
  return o.text("status", describe(explanation.status))
      .number("relaxation", explanation.relaxation)
      .raw("missing", list_of(explanation.shortages, [](const Shortage& s) { return json_of(s); }))
      .raw("gives_way",
           list_of(explanation.gives_way, [](const SoftShortage& s) { return json_of(s); }))
      .text("gives_way_to", explanation.gives_way_to)
      .number("cost", explanation.cost)
      .raw("remedies", list_of(explanation.remedies, [](const Remedy& r) { return json_of(r); }))
      .number("seconds", explanation.seconds)
      .str();
}

}  // namespace saltus
