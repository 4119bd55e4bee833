#include "saltus/autodiff/scalar_program.hpp"

namespace saltus::detail {

ScalarProgram::ScalarProgram(const ExpressionGraph& graph, int inputs,
                             const std::vector<int>& first, const std::vector<int>& second)
    : slots_(1 + inputs), slot_(graph.size(), -1) {
  slot_[0] = 0;
  add(graph, first, 0);
  add(graph, second, 1);
}

void ScalarProgram::add(const ExpressionGraph& graph, const std::vector<int>& roots, int part) {
  first_product_[part] = static_cast<int>(products_.size());
  first_call_[part] = static_cast<int>(calls_.size());
  std::vector<char> needed(graph.size(), 0);
  for (const int root : roots) needed[root] = 1;
  for (int i = graph.size(); i-- > 0;) {
    if (!needed[i]) continue;
    const ExpressionNode& node = graph[i];
    for (const Product& p : node.sum) needed[p.a] = needed[p.b] = 1;
    for (const int argument : {node.a, node.b})
      if (argument >= 0) needed[argument] = 1;
  }
  for (int i = 0; i < graph.size(); ++i) {
    if (!needed[i] || slot_[i] >= 0) continue;
    const ExpressionNode& node = graph[i];
    if (node.input >= 0) {
      slot_[i] = slot_of_input(node.input);
      continue;
    }
    slot_[i] = slots_++;
    if (node.function != Elementary::none) {
      calls_.push_back({slot_[node.a], node.b < 0 ? 0 : slot_[node.b], node.parameter});
      rows_.push_back({node.function, slot_[i], static_cast<int>(calls_.size())});
      operations_[part] += node.function <= Elementary::inverse_or_zero ? 4 : function_cost;
    } else if (node.sum.size() == 1 && node.sum.front().a == 0) {
      constants_.push_back({slot_[i], node.sum.front().scale});
    } else {
      for (const Product& p : node.sum) products_.push_back({p.scale, slot_[p.a], slot_[p.b]});
      rows_.push_back({node.function, slot_[i], static_cast<int>(products_.size())});
      operations_[part] += 1 + static_cast<int>(node.sum.size());
    }
  }
  end_[part] = static_cast<int>(rows_.size());
}

void ScalarProgram::prepare(double* slots) const {
  slots[0] = 1.0;
  for (const Constant& c : constants_) slots[c.to] = c.value;
}

void ScalarProgram::run(int part, double* slots) const {
  const Row* row = rows_.data() + (part == 0 ? 0 : end_[0]);
  const Row* const end = rows_.data() + end_[part];
  const Product* p = products_.data() + first_product_[part];
  const Call* call = calls_.data() + first_call_[part];
  for (; row != end; ++row) {
    if (row->function != Elementary::none) {
      slots[row->to] = evaluate(row->function, call->parameter, slots[call->a], slots[call->b]);
      ++call;
      continue;
    }
    const Product* const last = products_.data() + row->end;
    double sum = p->scale * slots[p->a] * slots[p->b];
    while (++p != last) sum += p->scale * slots[p->a] * slots[p->b];
    slots[row->to] = sum;
  }
}

}  // namespace saltus::detail
