#include "saltus/robots/walking/unmet_decision.hpp"

#include <algorithm>
#include <utility>

namespace saltus::robots::walking {

void UnmetDecisions::keep(const std::string& decision, double time, double missed,
                          const MultipleShooting& shooting) {
  const auto of_kind = [&](const UnmetDecision& d) { return d.decision == decision; };
  const auto first = std::ranges::find_if(kept_, of_kind);
  const auto worst =
      first == kept_.end() ? kept_.end() : std::find_if(first + 1, kept_.end(), of_kind);
  const auto& worst_so_far = worst == kept_.end() ? first : worst;
  if (first != kept_.end() && missed <= worst_so_far->missed) return;
  UnmetDecision unmet{{time, current_problem(shooting), shooting.options()}, decision, missed};
  unmet.problem.start_time(time);
  if (worst != kept_.end())
    *worst = std::move(unmet);
  else
    kept_.push_back(std::move(unmet));
}

std::vector<UnmetDecision> UnmetDecisions::take() {
  std::ranges::stable_sort(kept_, {}, &UnmetDecision::time);
  return std::exchange(kept_, {});
}

}  // namespace saltus::robots::walking
