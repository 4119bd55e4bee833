#include "tests/metamorphic/scaled_function.hpp"

#include <array>
#include <memory>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus::metamorphic {
namespace {

constexpr int most = 256;

class ScaledBody final : public FunctionBody {
 public:
  ScaledBody(Function f, const VectorXd& columns, const VectorXd& rows)
      : FunctionBody(f.inputs(), f.outputs()), f_(std::move(f)), columns_(columns), rows_(rows) {
    if (inputs() > most || outputs() > most) throw DefinitionError("scaled: too many numbers");
    jacobian_pattern_ = f_.jacobian_pattern();
    hessian_pattern_ = f_.hessian_pattern();
  }

  int degree(int output, const std::vector<char>& variable) const override {
    return f_.degree(output, variable);
  }
  bool reads(int input) const override { return f_.reads(input); }
  void value(const double* z, double* y) const override {
    const Numbers argument = at(z);
    f_.value(argument.data(), y);
    scale_rows(y);
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    const Numbers argument = at(z);
    f_.jacobian(argument.data(), y, entries);
    scale_rows(y);
    jacobian_pattern_.for_each([&](int r, int c, int e) { entries[e] *= rows_[r] * columns_[c]; });
  }
  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    const Numbers argument = at(z);
    Numbers scaled_weights;
    for (int r = 0; r < outputs(); ++r) scaled_weights[r] = weights[r] * rows_[r];
    f_.hessian(argument.data(), scaled_weights.data(), entries, curvature);
    hessian_pattern_.for_each(
        [&](int i, int j, int e) { entries[e] *= columns_[i] * columns_[j]; });
  }
  bool is_reentrant() const override { return f_.is_reentrant(); }
  std::shared_ptr<const FunctionBody> separate() const override {
    Function other = f_.separate();
    return other ? std::make_shared<ScaledBody>(std::move(other), columns_, rows_) : nullptr;
  }

 private:
  using Numbers = std::array<double, most>;
  Numbers at(const double* z) const {
    Numbers argument;
    for (int i = 0; i < inputs(); ++i) argument[i] = columns_[i] * z[i];
    return argument;
  }
  void scale_rows(double* y) const {
    for (int r = 0; r < outputs(); ++r) y[r] *= rows_[r];
  }

  Function f_;
  VectorXd columns_, rows_;
};

class AffineBody final : public FunctionBody {
 public:
  AffineBody(const VectorXd& weights, double offset)
      : FunctionBody(static_cast<int>(weights.size()), 1), weights_(weights), offset_(offset) {
    std::vector<std::pair<int, int>> entries;
    for (int i = 0; i < inputs(); ++i)
      if (weights[i] != 0.0) entries.emplace_back(0, i);
    jacobian_pattern_ = SparsityPattern::from_pairs(1, inputs(), std::move(entries));
    hessian_pattern_ = SparsityPattern(inputs(), inputs());
  }
  void value(const double* z, double* y) const override {
    *y = offset_;
    for (int i = 0; i < inputs(); ++i)
      if (weights_[i] != 0.0) *y += weights_[i] * z[i];
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    jacobian_pattern_.for_each([&](int, int c, int e) { entries[e] = weights_[c]; });
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}
  bool is_reentrant() const override { return true; }

 private:
  VectorXd weights_;
  double offset_;
};

}  // namespace

Function scaled(const Function& f, const VectorXd& columns, const VectorXd& rows) {
  return Function(std::unique_ptr<const FunctionBody>(new ScaledBody(f, columns, rows)));
}

Function affine(const VectorXd& weights, double offset) {
  return Function(std::unique_ptr<const FunctionBody>(new AffineBody(weights, offset)));
}

}  // namespace saltus::metamorphic
