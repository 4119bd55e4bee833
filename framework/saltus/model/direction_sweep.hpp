// Propagates several directions of differentiation at once through the local derivatives of a
// formula.
//
// Derivatives along all directions are stored together, one pack per node. A row computes a pack as
// a linear combination of earlier packs. Its coefficients are numbers of a scalar program. Rows
// exist only for packs that are not zero and that an entry needs.
#pragma once

#include <vector>

#include "saltus/model/make_function.hpp"

namespace saltus::detail {

/// One sweep and the entries of a matrix that follow from it.
class DirectionSweep {
 public:
  /// A linear term of a row.
  struct Term {
    int coefficient = 0;  ///< node of the coefficient; its slot after resolve()
    int source = 0;       ///< index of the pack
  };

  /// A sweep of at most `lanes` directions. Packs 0 to lanes - 1 are the unit vectors.
  explicit DirectionSweep(int lanes) : lanes_(lanes), packs_(lanes + 1) {}

  /// Number of directions in a pack, rounded to a width of the processor.
  int lanes() const { return lanes_; }
  /// The pack of zeros.
  int zero() const { return lanes_; }
  /// Appends a row. Returns the index of its pack.
  int add(const std::vector<Term>& terms);
  /// Entry `entry` of the result is this lane of a pack.
  void read(int pack, int lane, int entry) { readings_.push_back({pack, lane, entry}); }
  /// Calls visit(term) for every term. Used to replace nodes by slots.
  template <class Visit>
  void for_each_term(Visit&& visit) {
    for (Term& term : terms_) visit(term);
  }
  /// Number of operations, comparable with those of a scalar program.
  int operations() const { return static_cast<int>(rows_.size() + terms_.size()); }
  /// Number of doubles of a workspace.
  int workspace() const { return packs_ * lanes_; }

  /// Writes the unit vectors and the zeros. Sweeps with equal lanes() can share a workspace.
  void prepare(double* packs) const;
  /// Computes all packs and writes the entries.
  void run(const double* slots, double* packs, double* entries) const;

 private:
  template <int lanes>
  void propagate(const double* slots, double* packs) const;

  int lanes_;
  int packs_;
  std::vector<int> rows_;  // end of the terms of each row; its pack follows the previous one
  std::vector<Term> terms_;
  std::vector<Reading> readings_;  // `row` is the index of a pack
};

/// The narrowest pack for this number of directions, at most `native_lanes`.
int lanes_of(int directions);

}  // namespace saltus::detail
