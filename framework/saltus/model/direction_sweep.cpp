#include "saltus/model/direction_sweep.hpp"

#include <algorithm>

#include "saltus/autodiff/dual.hpp"

namespace saltus::detail {

int lanes_of(int directions) { return lanes_for(directions); }

int DirectionSweep::add(const std::vector<Term>& terms) {
  terms_.insert(terms_.end(), terms.begin(), terms.end());
  rows_.push_back(static_cast<int>(terms_.size()));
  return packs_++;
}

void DirectionSweep::prepare(double* packs) const {
  std::fill_n(packs, (lanes_ + 1) * lanes_, 0.0);
  for (int lane = 0; lane < lanes_; ++lane) packs[lane * lanes_ + lane] = 1.0;
}

template <int lanes>
void DirectionSweep::propagate(const double* slots, double* packs) const {
  using Packed = typename Pack<lanes>::Lanes;
  const auto pack = [packs](int index) -> Packed& {
    return *reinterpret_cast<Packed*>(packs + static_cast<std::ptrdiff_t>(index) * lanes);
  };
  const Term* term = terms_.data();
  int to = lanes + 1;
  for (const int end : rows_) {
    const Term* const last = terms_.data() + end;
    Packed sum = slots[term->coefficient] * pack(term->source);
    while (++term != last) sum += slots[term->coefficient] * pack(term->source);
    pack(to++) = sum;
  }
}

void DirectionSweep::run(const double* slots, double* packs, double* entries) const {
  switch (lanes_) {
    case 1:
      propagate<1>(slots, packs);
      break;
    case 2:
      propagate<2>(slots, packs);
      break;
    case 4:
      if constexpr (native_lanes >= 4) propagate<4>(slots, packs);
      break;
    default:
      if constexpr (native_lanes >= 8) propagate<8>(slots, packs);
  }
  for (const Reading& r : readings_) entries[r.entry] = packs[r.row * lanes_ + r.lane];
}

}  // namespace saltus::detail
