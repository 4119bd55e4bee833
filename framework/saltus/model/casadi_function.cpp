#include "saltus/model/casadi_function.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/workspace_pool.hpp"

namespace saltus {
namespace {

using Integer = long long;  // casadi_int

// A sparsity pattern in CasADi's format: rows, columns, then the starts of the columns and the rows
// of the entries, column by column. A 1 in place of the first start means that all entries exist.
class Pattern {
 public:
  explicit Pattern(const Integer* data) : data_(data) {}
  int rows() const { return static_cast<int>(data_[0]); }
  int columns() const { return static_cast<int>(data_[1]); }
  bool is_dense() const { return data_[2] == 1; }
  int entries() const {
    return is_dense() ? rows() * columns() : static_cast<int>(data_[2 + columns()]);
  }
  /// (row, column) of every entry in the order of CasADi.
  std::vector<std::pair<int, int>> pairs() const {
    std::vector<std::pair<int, int>> all;
    for (int c = 0; c < columns(); ++c) {
      if (is_dense()) {
        for (int r = 0; r < rows(); ++r) all.emplace_back(r, c);
        continue;
      }
      const Integer* row = data_ + 3 + columns();
      for (Integer k = data_[2 + c]; k < data_[3 + c]; ++k)
        all.emplace_back(static_cast<int>(row[k]), c);
    }
    return all;
  }

 private:
  const Integer* data_;
};

// One generated function.
class Generated {
 public:
  Generated(void* library, const std::string& path, const std::string& name)
      : library_(library), name_(name) {
    evaluate_ = find<Evaluate>("", path);
    inputs_ = static_cast<int>(find<Count>("_n_in", path)());
    outputs_ = static_cast<int>(find<Count>("_n_out", path)());
    sparsity_in_ = find<Sparsity>("_sparsity_in", path);
    sparsity_out_ = find<Sparsity>("_sparsity_out", path);
    if (find<Work>("_work", path)(&arguments_, &results_, &integers_, &reals_) != 0)
      throw InputError(fmt::format("{}: '{}_work' failed", path, name));
    checkout_ = reinterpret_cast<Checkout>(dlsym(library, (name + "_checkout").c_str()));
    if (const auto hold = reinterpret_cast<Hold>(dlsym(library, (name + "_incref").c_str())))
      hold();
  }

  const std::string& name() const { return name_; }
  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  Pattern input(int i) const { return Pattern(sparsity_in_(i)); }
  Pattern output(int i) const { return Pattern(sparsity_out_(i)); }

  // Work space of one call.
  struct Workspace {
    std::vector<const double*> arguments;
    std::vector<double*> results;
    std::vector<Integer> integers;
    std::vector<double> reals;
    std::vector<double> entries;  // a matrix in the order of CasADi
    int memory = 0;
  };
  Workspace workspace(int entries) const {
    Workspace w{std::vector<const double*>(arguments_), std::vector<double*>(results_),
                std::vector<Integer>(integers_),        std::vector<double>(reals_),
                std::vector<double>(entries),           0};
    if (checkout_ != nullptr) w.memory = checkout_();
    if (w.memory < 0)
      throw InputError(fmt::format(
          "'{}_checkout' has no memory left; compile the code with a larger CASADI_MAX_NUM_THREADS",
          name_));
    return w;
  }
  // Writes NaN on failure.
  void call(Workspace& w, double* first, int first_size, double* second, int second_size) const {
    w.results[0] = first;
    if (outputs_ > 1) w.results[1] = second;
    if (evaluate_(w.arguments.data(), w.results.data(), w.integers.data(), w.reals.data(),
                  w.memory) == 0)
      return;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::fill_n(first, first_size, nan);
    if (outputs_ > 1) std::fill_n(second, second_size, nan);
  }

 private:
  using Evaluate = int (*)(const double**, double**, Integer*, double*, int);
  using Count = Integer (*)();
  using Sparsity = const Integer* (*)(Integer);
  using Work = int (*)(Integer*, Integer*, Integer*, Integer*);
  using Checkout = int (*)();
  using Hold = void (*)();

  template <class F>
  F find(const char* suffix, const std::string& path) const {
    void* const symbol = dlsym(library_, (name_ + suffix).c_str());
    if (symbol == nullptr)
      throw InputError(
          fmt::format("{}: there is no function '{}{}' of CasADi; generate the function with its "
                      "companions '_jacobian' and '_hessian' (saltus/model/casadi_function.hpp)",
                      path, name_, suffix));
    return reinterpret_cast<F>(symbol);
  }

  void* library_;
  std::string name_;
  Evaluate evaluate_ = nullptr;
  Checkout checkout_ = nullptr;
  Sparsity sparsity_in_ = nullptr, sparsity_out_ = nullptr;
  int inputs_ = 0, outputs_ = 0;
  Integer arguments_ = 0, results_ = 0, integers_ = 0, reals_ = 0;
};

// The generated pattern in row order, and the position of each generated entry in it.
struct Ordered {
  SparsityPattern pattern;
  std::vector<int> position;

  explicit Ordered(const Pattern& given)
      : pattern(SparsityPattern::from_pairs(given.rows(), given.columns(), given.pairs())) {
    for (const auto& [row, column] : given.pairs()) position.push_back(pattern.find(row, column));
  }
  void scatter(const std::vector<double>& given, double* entries) const {
    for (std::size_t k = 0; k < position.size(); ++k) entries[position[k]] = given[k];
  }
};

struct Code {
  Generated value, jacobian, hessian;
  std::vector<int> starts;  // index in z of each input
  Ordered first, second;
};

class CasadiBody final : public FunctionBody {
 public:
  CasadiBody(std::shared_ptr<const Code> code, int inputs,
             detail::Lending lending = detail::Lending::shared)
      : FunctionBody(inputs, code->value.output(0).rows()),
        code_(std::move(code)),
        workspaces_(lending) {
    jacobian_pattern_ = code_->first.pattern;
    hessian_pattern_ = code_->second.pattern;
    workspaces_.add(new_workspace());
  }

  bool is_reentrant() const override { return workspaces_.is_shared(); }
  std::shared_ptr<const FunctionBody> separate() const override {
    return std::make_shared<CasadiBody>(code_, inputs(), detail::Lending::exclusive);
  }

  void value(const double* z, double* y) const override {
    const auto w = lend();
    load(z, w->value);
    code_->value.call(w->value, y, outputs(), nullptr, 0);
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    const auto w = lend();
    load(z, w->jacobian);
    std::vector<double>& given = w->jacobian.entries;
    code_->jacobian.call(w->jacobian, y, outputs(), given.data(), static_cast<int>(given.size()));
    code_->first.scatter(given, entries);
  }
  void hessian(const double* z, const double* weights, double* entries, Curvature) const override {
    const auto w = lend();
    load(z, w->hessian);
    w->hessian.arguments[code_->starts.size()] = weights;
    std::vector<double>& given = w->hessian.entries;
    code_->hessian.call(w->hessian, given.data(), static_cast<int>(given.size()), nullptr, 0);
    code_->second.scatter(given, entries);
  }

 private:
  struct Workspaces {
    Generated::Workspace value, jacobian, hessian;
  };
  void load(const double* z, Generated::Workspace& w) const {
    for (std::size_t i = 0; i < code_->starts.size(); ++i) w.arguments[i] = z + code_->starts[i];
  }
  std::unique_ptr<Workspaces> new_workspace() const {
    return std::make_unique<Workspaces>(
        Workspaces{code_->value.workspace(0),
                   code_->jacobian.workspace(static_cast<int>(code_->first.position.size())),
                   code_->hessian.workspace(static_cast<int>(code_->second.position.size()))});
  }
  detail::WorkspacePool<Workspaces>::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }

  std::shared_ptr<const Code> code_;
  detail::WorkspacePool<Workspaces> workspaces_;
};

[[noreturn]] void refuse(const std::string& path, const Generated& function,
                         const std::string& what) {
  throw DefinitionError(fmt::format("{}: the function '{}' {}", path, function.name(), what));
}

void check_output(const std::string& path, const Generated& function, int output, int rows,
                  int columns) {
  if (function.outputs() <= output)
    refuse(path, function,
           fmt::format("has {} outputs, expected {}", function.outputs(), output + 1));
  const Pattern given = function.output(output);
  if (given.rows() != rows || given.columns() != columns)
    refuse(path, function,
           fmt::format("has an output {} of {} x {}, expected {} x {}", output, given.rows(),
                       given.columns(), rows, columns));
}

}  // namespace

Function load_casadi(const std::string& library, const std::string& name, const Arguments& sizes) {
  // A path without a slash would be searched for in the system's folders.
  const std::string path = library.find('/') == std::string::npos ? "./" + library : library;
  void* const handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw InputError(fmt::format("cannot load the library: {}", dlerror()));
  const Generated value(handle, library, name), jacobian(handle, library, name + "_jacobian"),
      hessian(handle, library, name + "_hessian");

  const int expected[] = {1, sizes.nx, sizes.nu, sizes.np};
  constexpr const char* names[] = {"t", "x", "u", "p"};
  const int count = value.inputs();
  if (count < 2 || count > 4)
    refuse(library, value,
           fmt::format("has {} inputs; it must be a function of (t, x), (t, x, u) or "
                       "(t, x, u, p)",
                       count));
  std::vector<int> starts{0};
  for (const Generated* function : {&value, &jacobian, &hessian}) {
    if (function->inputs() != count + (function == &hessian ? 1 : 0))
      refuse(library, *function,
             fmt::format("has {} inputs, expected {}", function->inputs(),
                         count + (function == &hessian ? 1 : 0)));
    for (int i = 0; i < count; ++i)
      if (const Pattern given = function->input(i); given.entries() != expected[i])
        refuse(library, *function,
               fmt::format("has {} entries in input {}, but {} has {}", given.entries(), i,
                           names[i], expected[i]));
  }
  for (int i = 0; i + 1 < count; ++i) starts.push_back(starts.back() + expected[i]);
  if (value.outputs() < 1) refuse(library, value, "has no output");
  const int rows = value.output(0).rows(), inputs = starts.back() + expected[count - 1];
  check_output(library, value, 0, rows, 1);
  if (value.output(0).entries() != rows)
    refuse(library, value, "has a sparse output; make it dense with densify()");
  check_output(library, jacobian, 0, rows, 1);
  check_output(library, jacobian, 1, rows, inputs);
  check_output(library, hessian, 0, inputs, inputs);
  if (jacobian.output(0).entries() != rows)
    refuse(library, jacobian, "has a sparse output; make it dense with densify()");
  if (hessian.input(count).entries() != rows)
    refuse(library, hessian,
           fmt::format("has {} weights, expected {}", hessian.input(count).entries(), rows));
  for (const auto& [row, column] : hessian.output(0).pairs())
    if (column > row)
      refuse(library, hessian,
             fmt::format("has the entry ({}, {}), but it must return the lower "
                         "triangle: tril(...)",
                         row, column));
  // Patterns for all of (t, x, u, p), also if the function does not take all of them.
  const auto wide = [&](Ordered ordered, int height) {
    std::vector<std::pair<int, int>> pairs;
    ordered.pattern.for_each([&](int r, int c, int) { pairs.emplace_back(r, c); });
    ordered.pattern = SparsityPattern::from_pairs(height, sizes.size(), std::move(pairs));
    return ordered;
  };
  auto code = std::make_shared<const Code>(Code{value, jacobian, hessian, std::move(starts),
                                                wide(Ordered(jacobian.output(1)), rows),
                                                wide(Ordered(hessian.output(0)), sizes.size())});
  return Function(std::make_shared<const CasadiBody>(std::move(code), sizes.size()));
}

}  // namespace saltus
