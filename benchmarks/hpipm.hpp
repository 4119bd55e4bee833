// HPIPM (github.com/giaf/hpipm) on the programs of our benchmarks, from a shared library that is
// opened when it is asked for: nothing of it is needed to build.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// Of its modes those that reach a KKT residual of 1e-8: quick, and careful where rows bind.
enum class HpipmMode { speed = 1, balance = 2 };

/// Its functions. Throws InputError: no such file, no HPIPM, a version that lacks a function.
class HpipmLibrary {
 public:
  explicit HpipmLibrary(const std::filesystem::path& file);
  ~HpipmLibrary();
  HpipmLibrary(const HpipmLibrary&) = delete;
  HpipmLibrary& operator=(const HpipmLibrary&) = delete;

  struct Functions;
  const Functions& functions() const { return *functions_; }

 private:
  void* handle_ = nullptr;
  std::unique_ptr<Functions> functions_;
};

/// A solver for programs with the sizes of `program`: a fixed start, which is eliminated, and rows,
/// but no bounds and nothing soft.
class Hpipm {
 public:
  Hpipm(const HpipmLibrary& library, const StageQp& program, HpipmMode mode, double tolerance);
  ~Hpipm();

  /// Takes the program's data in.
  void load(const StageQp& qp);
  /// Where a warm solve begins.
  void start_at(const StageQp& qp, const StagePoint& point);
  /// From its own start, from start_at()'s states and inputs, or from all of it.
  enum class Start { own, primal, primal_and_dual };
  /// Whether this version has the last of them.
  bool takes_multipliers() const;
  void solve(Start start = Start::own);
  int iterations() const;
  void read(const StageQp& qp, StagePoint& point) const;

 private:
  struct Memory;
  const HpipmLibrary::Functions& f_;
  std::unique_ptr<Memory> m_;
  std::vector<int> rows_;  ///< per stage
};

}  // namespace saltus::bench
