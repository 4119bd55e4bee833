// A sparse program assembled from small functions: knows blocks and patterns, but no phases.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/entry_target.hpp"
#include "saltus/core/thread_pool.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Part of an argument that comes from a variable: argument += factor * w[variable].
struct VariableCoefficient {
  int variable = 0;     ///< which one
  double factor = 1.0;  ///< its coefficient
};

/// Where an output of a block goes.
struct BlockOutput {
  static constexpr int objective = -1;  ///< stands for the cost in place of a row
  int row = objective;                  ///< of the program, or `objective`
  double factor = 1.0;  ///< rows: fixed; objective: a weight that may change between solves
};

/// One small function of a few variables and constants.
struct Block {
  Function function;                                           ///< what is evaluated
  std::vector<std::vector<VariableCoefficient>> coefficients;  ///< per argument
  VectorXd constants;                ///< per argument; may change between solves
  std::vector<BlockOutput> outputs;  ///< per output

  Block() = default;
  /// Without coefficients, constants zero; outputs to be given in their order.
  explicit Block(Function f, std::vector<BlockOutput> to = {})
      : function(std::move(f)),
        coefficients(function.inputs()),
        constants(VectorXd::Zero(function.inputs())),
        outputs(std::move(to)) {}
};

/// Set-up: add variables, rows, linear entries and blocks in any order, then finish(). After that
/// sizes and patterns are fixed; constants, bounds and objective weights may change. Blocks are
/// evaluated again only where their variables or constants changed. Evaluations do not allocate,
/// and with one thread they know no others.
class BlockProgram : public NonlinearProgram {
 public:
  BlockProgram() = default;
  BlockProgram(const BlockProgram&) = delete;
  BlockProgram& operator=(const BlockProgram&) = delete;

  int add_variables(int count);  ///< returns the first; free until bounded
  int add_rows(int count);       ///< returns the first; free until bounded
  int add_block(Block block);    ///< returns its index
  /// Adds coefficient times variable to a row.
  void add_linear(int row, int variable, double coefficient);
  /// Before finish(): how many threads evaluate blocks, 1 at first. Results are the same to the
  /// bit. Blocks whose functions cannot be separated are all evaluated by the calling thread.
  void set_threads(int threads);
  /// Fixes the patterns; nothing is added afterwards.
  void finish();

  /// Bounds of variable i.
  void bound_variable(int i, double lower, double upper) {
    if (lower_[i] == lower && upper_[i] == upper) return;
    lower_[i] = lower;
    upper_[i] = upper;
    ++bounds_revision_;
  }
  /// Bounds of row i.
  void bound_row(int i, double lower, double upper) {
    if (row_lower_[i] == lower && row_upper_[i] == upper) return;
    const bool was_off = is_off(i);
    row_lower_[i] = lower;
    row_upper_[i] = upper;
    ++bounds_revision_;
    if (is_off(i) != was_off) ++revision_;
  }
  /// An equality stays one, at another value: what a measurement does. Not counted as a change.
  void move_equality(int i, double value) { row_lower_[i] = row_upper_[i] = value; }
  /// Sets an argument of a block that is data.
  void set_constant(int block, int argument, double value);
  /// Sets the factor of a block's output.
  void set_weight(int block, int output, double value);
  /// Of a block's output.
  double weight(int block, int output) const { return blocks_[block].outputs[output].factor; }
  /// Cost a w + b/2 w^2 of a single variable; b needs to have been declared before finish().
  void set_variable_cost(int variable, double linear, double quadratic);
  /// The cost is quadratic in this variable.
  void declare_quadratic(int variable) { quadratic_variables_.push_back(variable); }
  /// Solvers drop to limited memory for kinds of curvature that some block cannot deliver.
  void set_support(bool exact, bool gauss_newton) {
    exact_ = exact;
    gauss_newton_ = gauss_newton;
  }

  /// What a variable of its own costs at w.
  double variable_cost(int variable, double w) const {
    return (linear_cost_[variable] + 0.5 * quadratic_cost_[variable] * w) * w;
  }
  /// What the program consists of, for those who write it down elsewhere.
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Calls visit(row, variable, coefficient) for every linear entry; they add up.
  template <class Visit>
  void for_each_linear(Visit&& visit) const {
    for (const Linear& l : linear_) visit(l.row, l.variable, l.coefficient);
  }
  /// How many the function of a block gives.
  int block_outputs(int block) const { return blocks_[block].function.outputs(); }
  // The Jacobian without a sparse matrix, for programs that are written where they are solved.
  /// Values and derivatives at w; false where they do not exist.
  bool evaluate_derivatives(const double* w) { return evaluate(w, Level::derivatives); }
  /// Writes every entry at w to its target; of rows that are off nothing. False where the program
  /// cannot be evaluated; linear entries are written then, too.
  bool write_jacobian(const double* w, std::span<const EntryTarget> targets);
  // With the derivatives of the last evaluation.
  void multiply_jacobian(const VectorXd& v, VectorXd& out) const;             ///< out = J v
  void add_jacobian_transposed(const VectorXd& lambda, VectorXd& out) const;  ///< out += J' lambda
  /// Outputs of a block at w (for reports).
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
  /// Counts the changes of bounds, as revision() counts those of everything else.
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
  // A row without bounds: its term is not in force. It is not evaluated, and its blocks add nothing
  // to its value and derivatives.
  bool is_off(int row) const { return row_lower_[row] == -infinity && row_upper_[row] == infinity; }
  bool counts(const BlockOutput& output) const {
    return output.factor != 0.0 && (output.row == BlockOutput::objective || !is_off(output.row));
  }

  enum class Level { none, values, derivatives };

  // local entry -> position in the pattern, with the product of its fixed factors
  struct Scatter {
    int from, to, output;
    double factor;
    bool adds = false;  // to what a linear entry or this block has put there
  };
  // One that threads must not take part in, because others write there too.
  struct SharedScatter {
    int block;
    Scatter scatter;
  };
  struct Compiled {
    std::vector<Scatter> rows, jacobian, gradient, hessian;  // rows: of the value
    int first_objective_term = 0;
    VectorXd argument, value, weights;   // argument: constants, once gathered with the shares
    std::vector<int> with_coefficients;  // arguments that have coefficients
    std::vector<double> entries, hessian_entries;
    std::vector<char> reads;   // per argument: whether the function depends on it
    std::vector<int> read;     // those arguments
    int before = -1;           // the last block of this thread with the same function, -1: none
    std::vector<int> degrees;  // of the outputs, in the block's variables
    bool is_affine = false, is_quadratic = false;
    bool is_curved = false;  // adds to the Hessian

    // What `value`, `entries` and `hessian_entries` hold.
    Level level = Level::none;  // none: constants changed
    long point = 0;             // at which they were evaluated
    bool has_entries = false;   // for the present constants
    bool has_hessian = false;
    bool counts_hessian = false;  // some weight is not zero
    long hessian_point = 0;
    Curvature hessian_curvature = Curvature::exact;
    VectorXd hessian_weights;
  };

  static void gather(const Block& block, Compiled& compiled, const double* w);
  void move_to(const double* w);
  bool evaluate(const double* w, Level level);
  // Calls work(blocks) once per thread with the indices of its blocks, in order.
  template <class Work>
  void share_out(const Work& work);
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
    bool adds = false;  // to another linear entry
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
  std::unique_ptr<ThreadPool> pool_;      // of more than one thread
  std::vector<std::vector<int>> shares_;  // blocks of each thread
  std::vector<char> finite_in_share_;
  std::vector<SharedScatter> shared_rows_, shared_jacobian_, shared_gradient_, shared_hessian_;
  std::vector<double> objective_terms_;  // in the order of blocks and outputs

  VectorXd last_w_;
  long point_ = 0;     // counts the points visited
  long revision_ = 1;  // counts the changes of data
  long bounds_revision_ = 1;
  Level level_ = Level::none;
  long evaluated_point_ = 0, evaluated_revision_ = 0;
  bool finite_ = false;
};

}  // namespace saltus
