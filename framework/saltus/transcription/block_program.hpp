// A sparse program assembled from small functions. It consists of blocks and patterns and does not
// depend on phases.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/core/thread_pool.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Contribution of a variable to an argument: argument += factor * w[variable].
struct VariableCoefficient {
  int variable = 0;     ///< index of the variable
  double factor = 1.0;  ///< its coefficient
};

/// Destination of an output of a block.
struct BlockOutput {
  static constexpr int objective = -1;  ///< denotes the cost instead of a row
  int row = objective;                  ///< row of the program, or `objective`
  double factor = 1.0;  ///< rows: fixed; objective: a weight, may change between solves
};

/// A function of a few variables and constants.
struct Block {
  Function function;                                           ///< the function
  std::vector<std::vector<VariableCoefficient>> coefficients;  ///< per argument
  VectorXd constants;                ///< per argument; may change between solves
  std::vector<BlockOutput> outputs;  ///< per output

  Block() = default;
  /// A block with zero constants and without coefficients. `to` lists the outputs in order.
  explicit Block(Function f, std::vector<BlockOutput> to = {})
      : function(std::move(f)),
        coefficients(function.inputs()),
        constants(VectorXd::Zero(function.inputs())),
        outputs(std::move(to)) {}
};

/// At set-up, add variables, rows, linear entries and blocks in any order, then call finish(). This
/// fixes sizes and patterns. Constants, bounds and objective weights may change later. A block is
/// evaluated again only if its variables or constants changed. Evaluations do not allocate. With
/// one thread they use no synchronisation.
class BlockProgram : public NonlinearProgram {
 public:
  BlockProgram() = default;
  BlockProgram(const BlockProgram&) = delete;
  BlockProgram& operator=(const BlockProgram&) = delete;

  int add_variables(int count);  ///< returns the first index; unbounded at first
  int add_rows(int count);       ///< returns the first index; unbounded at first
  int add_block(Block block);    ///< returns its index
  /// Adds coefficient times variable to a row.
  void add_linear(int row, int variable, double coefficient);
  /// Number of threads that evaluate blocks, initially 1. Call it before finish(). Results are
  /// bitwise identical for any number. The calling thread evaluates blocks that cannot be
  /// separated.
  void set_threads(int threads);
  /// Fixes sizes and patterns.
  void finish();

  /// Sets the bounds of variable i.
  void bound_variable(int i, double lower, double upper) {
    if (lower_[i] == lower && upper_[i] == upper) return;
    lower_[i] = lower;
    upper_[i] = upper;
    ++bounds_revision_;
  }
  /// Sets the bounds of row i.
  void bound_row(int i, double lower, double upper) {
    if (row_lower_[i] == lower && row_upper_[i] == upper) return;
    const bool was_off = is_off(i);
    row_lower_[i] = lower;
    row_upper_[i] = upper;
    ++bounds_revision_;
    if (is_off(i) != was_off) ++revision_;
  }
  /// Changes the value of an equality row, e.g. for a measurement. Not counted as a change of
  /// bounds.
  void move_equality(int i, double value) { row_lower_[i] = row_upper_[i] = value; }
  /// Sets a constant argument of a block.
  void set_constant(int block, int argument, double value);
  /// Sets the factor of a block output.
  void set_weight(int block, int output, double value);
  /// Factor of a block output.
  double weight(int block, int output) const { return blocks_[block].outputs[output].factor; }
  /// Sets the cost a w + b/2 w^2 of one variable. If b is not zero, declare_quadratic() must
  /// precede finish().
  void set_variable_cost(int variable, double linear, double quadratic);
  /// Declares that the cost is quadratic in this variable.
  void declare_quadratic(int variable) { quadratic_variables_.push_back(variable); }
  /// Kinds of curvature that all blocks provide. For other kinds, solvers use limited-memory
  /// updates.
  void set_support(bool exact, bool gauss_newton) {
    exact_ = exact;
    gauss_newton_ = gauss_newton;
  }

  /// Separate cost of a variable at w, see set_variable_cost().
  double variable_cost(int variable, double w) const {
    return (linear_cost_[variable] + 0.5 * quadratic_cost_[variable] * w) * w;
  }
  /// The blocks of the program, for export.
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Calls visit(row, variable, coefficient) for every linear entry. Entries at the same position
  /// add up.
  template <class Visit>
  void for_each_linear(Visit&& visit) const {
    for (const Linear& l : linear_) visit(l.row, l.variable, l.coefficient);
  }
  /// Number of outputs of a block.
  int block_outputs(int block) const { return blocks_[block].function.outputs(); }
  // Jacobian products without a sparse matrix, for programs whose solver stores its own matrices.
  /// Evaluates values and derivatives at w. Returns false if they do not exist.
  bool evaluate_derivatives(const double* w) { return evaluate(w, Level::derivatives); }
  /// Writes every Jacobian entry at w to its target, except for inactive rows. Returns false if the
  /// program cannot be evaluated; linear entries are written even then.
  bool write_jacobian(const double* w, std::span<const detail::EntryTarget> targets);
  // The next two use the derivatives of the last evaluation.
  void multiply_jacobian(const VectorXd& v, VectorXd& out) const;             ///< out = J v
  void add_jacobian_transposed(const VectorXd& lambda, VectorXd& out) const;  ///< out += J' lambda
  /// Outputs of a block at w, for reports.
  void evaluate_block(int block, const double* w, double* outputs);

  int variables() const override { return static_cast<int>(lower_.size()); }
  int rows() const override { return static_cast<int>(row_lower_.size()); }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }
  const SparsityPattern& jacobian_pattern() const override { return jacobian_pattern_; }
  const SparsityPattern& hessian_pattern() const override { return hessian_pattern_; }
  bool supports(Curvature c) const override {
    return c == Curvature::exact ? exact_ : gauss_newton_;
  }
  bool has_curved_cost() const override { return curved_cost_; }
  bool is_linear_quadratic() const override { return linear_quadratic_; }
  bool is_affine(int row) const override { return affine_rows_[row] != 0; }
  long revision() const override { return revision_; }
  /// Counts changes of bounds. revision() counts all other changes.
  long bounds_revision() const { return bounds_revision_; }

  bool objective(const double* w, double& f) override;
  bool gradient(const double* w, double* gradient) override;
  bool constraints(const double* w, double* g) override;
  bool jacobian(const double* w, double* entries) override;
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override;
  void prepare_derivatives(const double* w, double sigma, const double* lambda,
                           Curvature curvature) override;

 private:
  // A row without bounds: its term is inactive. The row is not evaluated, and its blocks contribute
  // nothing to it.
  bool is_off(int row) const { return row_lower_[row] == -infinity && row_upper_[row] == infinity; }
  bool counts(const BlockOutput& output) const {
    return output.factor != 0.0 && (output.row == BlockOutput::objective || !is_off(output.row));
  }

  enum class Level { none, values, derivatives };

  // Maps a local entry to its position in the pattern, with the product of its fixed factors.
  struct Scatter {
    int from, to, output;
    double factor;
    bool adds = false;  // adds to a linear entry or an earlier entry of this block
  };
  // An entry written by the calling thread, because other threads write to the same position.
  struct SharedScatter {
    int block;
    Scatter scatter;
  };
  struct Compiled {
    std::vector<Scatter> rows, jacobian, gradient, hessian;  // rows: of the values
    int first_objective_term = 0;
    VectorXd argument, value, weights;   // argument: constants, plus coefficients once gathered
    std::vector<int> with_coefficients;  // arguments that have coefficients
    std::vector<double> entries, hessian_entries;
    std::vector<char> reads;   // per argument: true if the function depends on it
    std::vector<int> read;     // indices of those arguments
    int before = -1;           // previous block of this thread with the same function, or -1
    std::vector<int> degrees;  // degrees of the outputs in the variables of the block
    bool is_affine = false, is_quadratic = false;
    bool is_curved = false;  // contributes to the Hessian

    // Validity of `value`, `entries` and `hessian_entries`.
    Level level = Level::none;  // none: constants changed
    long point = 0;             // the point at which they were evaluated
    bool has_entries = false;   // valid for the present constants
    bool has_hessian = false;
    bool counts_hessian = false;  // some weight is non-zero
    long hessian_point = 0;
    Curvature hessian_curvature = Curvature::exact;
    VectorXd hessian_weights;
  };

  static void gather(const Block& block, Compiled& compiled, const double* w);
  void move_to(const double* w);
  bool evaluate(const double* w, Level level);
  // Calls work(blocks) once per thread with the indices of its blocks in order.
  template <class Work>
  void run_on_threads(const Work& work);
  template <class Add>
  void add_shared(std::vector<Scatter> Compiled::*list, const std::vector<SharedScatter>& shared,
                  const Add& add);
  template <class Visit>
  void for_each_jacobian_entry(const Visit& visit) const;
  bool all_shares_finite() const;
  void assign_threads();
  void separate_shared();
  bool weigh(const Block& block, Compiled& compiled, double sigma, const double* lambda,
             Curvature curvature) const;
  bool knows_hessian(const Compiled& compiled, Curvature curvature) const;
  void note_hessian(Compiled& compiled, Curvature curvature) const;
  void update(const Block& block, Compiled& compiled, const double* w, Level level);
  bool repeats(Compiled& compiled, Level level) const;
  void compile_block(const Block& block, Compiled& compiled) const;

  VectorXd lower_, upper_, row_lower_, row_upper_;
  std::vector<Block> blocks_;
  std::vector<Compiled> compiled_;
  struct Linear {
    int row, variable, position;
    double coefficient;
    bool adds = false;  // adds to another linear entry
  };
  std::vector<Linear> linear_;
  std::vector<int> quadratic_variables_;
  std::vector<int> quadratic_position_;  // per variable, or -1
  VectorXd linear_cost_, quadratic_cost_;
  SparsityPattern jacobian_pattern_, hessian_pattern_;
  bool exact_ = true, gauss_newton_ = true;

  bool linear_quadratic_ = false, curved_cost_ = false;
  std::vector<char> affine_rows_;

  int threads_ = 1;
  std::unique_ptr<ThreadPool> pool_;      // null for one thread
  std::vector<std::vector<int>> shares_;  // blocks of each thread
  std::vector<char> finite_in_share_;
  std::vector<SharedScatter> shared_rows_, shared_jacobian_, shared_gradient_, shared_hessian_;
  std::vector<double> objective_terms_;  // in order of blocks and outputs

  VectorXd last_w_;
  long point_ = 0;     // counts the evaluated points
  long revision_ = 1;  // counts changes of data
  long bounds_revision_ = 1;
  Level level_ = Level::none;
  long evaluated_point_ = 0, evaluated_revision_ = 0;
  bool finite_ = false;
};

}  // namespace saltus
