// Copies a quadratic program in stages into the packed form of RiccatiSystem. Private to it.
#pragma once

#include "saltus/qp/riccati_system.hpp"

namespace saltus::qp {

/// Most groups of inputs with a common resultant.
inline constexpr int max_parts = 8;

struct RiccatiSystem::Packer {
  RiccatiSystem& system;
  const StageQp& qp;
  int v = 0, y = 0, hard = 0, soft = 0, blocks = 0;
  bool ok = true;
  bool starts_fixed(int k) const { return k == 0 && qp.fixed_start; }
  bool starts_free(int k) const { return k == 0 && !qp.fixed_start; }

  double* numbers(int count) {
    double* result = system.numbers_.take(count);
    if (result == nullptr) ok = false;
    return result;
  }
  int* integers(int count) {
    int* result = system.integers_.take(count);
    if (result == nullptr) ok = false;
    return result;
  }

  // Where entry j of the user's v = (x, u) went: part, and place in it; part -1: it is constant.
  struct Column {
    int part, at;
  };
  Column column_of(int k, int j) const {
    const Stage& s = qp.stages[k];
    const PackedStage& p = system.stages_[k];
    if (j < s.nx) return starts_fixed(k) ? Column{-1, 0} : Column{0, j};
    const int input = j - s.nx;
    if (p.parts == 1) return {0, (starts_fixed(k) ? 0 : s.nx) + input};
    const int size = p.sweep.nu;
    return {input / size, (input < size ? p.sweep.nx : 0) + input % size};
  }

  bool run();
  void stage(int k);
  void choose_parts(int k);
  bool resultant_maps(int k, int parts);
  void flow(int k);
  void cost(int k);
  void groups(int k);
  void bounds(int k);
  bool columns_fit_parts(const Stage& s, int size) const;
  RowBlock& new_block(int k, int group, int rows, int columns, int part);
  void finish_block(int k, RowBlock& block, const RowBlock* twin);
  void place_rows(RowBlock& block, bool equalities, bool has_lower, bool has_upper);
  void add_group(int k, int g, bool equalities);
  void add_bound_rows(int k, int part, bool equalities);
  void fill_sides();
  bool is_settled(int k, int g, int row);
};

}  // namespace saltus::qp
