// HPIPM (github.com/giaf/hpipm) on the programs of our benchmarks. The shared library is opened at
// run time; the build does not need it.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// The modes that reach a KKT residual of 1e-8: a fast one, and a robust one for active rows.
enum class HpipmMode { speed = 1, balance = 2 };

/// The functions of the library. Throws InputError if the file is missing, is not HPIPM, or lacks a
/// function.
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

/// A solver for programs with the sizes of `program`: a fixed start, which is eliminated, and hard
/// rows, but no bounds and no soft rows.
class Hpipm {
 public:
  Hpipm(const HpipmLibrary& library, const qp::StageQp& program, HpipmMode mode, double tolerance);
  ~Hpipm();

  /// Copies the data of the program.
  void load(const qp::StageQp& qp);
  /// Sets the start of a warm solve.
  void start_at(const qp::StageQp& qp, const qp::StagePoint& point);
  /// Solves from the solver's own start, from the states and inputs of start_at(), or from the
  /// whole point.
  enum class Start { own, primal, primal_and_dual };
  /// True if this version supports the last kind of start.
  bool takes_multipliers() const;
  void solve(Start start = Start::own);
  int iterations() const;
  void read(const qp::StageQp& qp, qp::StagePoint& point) const;

 private:
  struct Memory;
  const HpipmLibrary::Functions& f_;
  std::unique_ptr<Memory> m_;
  std::vector<int> rows_;  ///< rows per stage
};

}  // namespace saltus::bench
