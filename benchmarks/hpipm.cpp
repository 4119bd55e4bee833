#include "benchmarks/hpipm.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "saltus/core/error.hpp"

namespace saltus::bench {

// Only the sizes of its structures are used, read from the library: versions differ in the rest.
struct HpipmLibrary::Functions {
  using Size = std::size_t (*)();
  Size dim_strsize, qp_strsize, sol_strsize, arg_strsize, ws_strsize;
  std::size_t (*dim_memsize)(int);
  void (*dim_create)(int, void*, void*);
  void (*dim_set)(const char*, int, int, void*);
  std::size_t (*qp_memsize)(void*);
  void (*qp_create)(void*, void*, void*);
  void (*qp_set)(const char*, int, const void*, void*);
  std::size_t (*sol_memsize)(void*);
  void (*sol_create)(void*, void*, void*);
  void (*sol_get)(const char*, int, void*, double*);
  void (*sol_set)(const char*, int, const double*, void*);
  std::size_t (*arg_memsize)(void*);
  void (*arg_create)(void*, void*, void*);
  void (*arg_set_default)(int, void*);
  void (*arg_set)(const char*, const void*, void*);
  std::size_t (*ws_memsize)(void*, void*);
  void (*ws_create)(void*, void*, void*, void*);
  void (*get)(const char*, void*, void*);
  void (*solve)(void*, void*, void*, void*);
  // Absent in old versions.
  void *lg_mask, *sol_set_pi;
};

namespace {

struct Free {
  void operator()(void* p) const { std::free(p); }
};
using Block = std::unique_ptr<void, Free>;

Block block(std::size_t size) {
  constexpr std::size_t line = 64;
  const std::size_t bytes = (size + line) / line * line;
  Block result(std::aligned_alloc(line, bytes));
  if (!result) throw std::bad_alloc();
  std::memset(result.get(), 0, bytes);
  return result;
}

// The bound that a version without masks treats as absent; with larger values it does not converge.
constexpr double far_away = 1e6;

}  // namespace

HpipmLibrary::HpipmLibrary(const std::filesystem::path& file)
    : functions_(std::make_unique<Functions>()) {
  if (!std::filesystem::exists(file))
    throw InputError(fmt::format("there is no library '{}'", file.string()));
  // In packages BLASFEO is in the same folder.
  const std::filesystem::path blasfeo = file.parent_path() / "libblasfeo.so";
  if (std::filesystem::exists(blasfeo)) dlopen(blasfeo.c_str(), RTLD_NOW | RTLD_GLOBAL);
  handle_ = dlopen(file.c_str(), RTLD_NOW);
  if (handle_ == nullptr) throw InputError(fmt::format("cannot open the library: {}", dlerror()));
  const auto find = [&](auto& function, const std::string& name) {
    void* at = dlsym(handle_, name.c_str());
    if (at == nullptr)
      throw InputError(fmt::format("'{}' is not a usable HPIPM library: it has no function {}",
                                   file.string(), name));
    std::memcpy(&function, &at, sizeof at);
  };
  Functions& f = *functions_;
  find(f.dim_strsize, "d_ocp_qp_dim_strsize");
  find(f.dim_memsize, "d_ocp_qp_dim_memsize");
  find(f.dim_create, "d_ocp_qp_dim_create");
  find(f.dim_set, "d_ocp_qp_dim_set");
  find(f.qp_strsize, "d_ocp_qp_strsize");
  find(f.qp_memsize, "d_ocp_qp_memsize");
  find(f.qp_create, "d_ocp_qp_create");
  find(f.qp_set, "d_ocp_qp_set");
  find(f.sol_strsize, "d_ocp_qp_sol_strsize");
  find(f.sol_memsize, "d_ocp_qp_sol_memsize");
  find(f.sol_create, "d_ocp_qp_sol_create");
  find(f.sol_get, "d_ocp_qp_sol_get");
  find(f.sol_set, "d_ocp_qp_sol_set");
  find(f.arg_strsize, "d_ocp_qp_ipm_arg_strsize");
  find(f.arg_memsize, "d_ocp_qp_ipm_arg_memsize");
  find(f.arg_create, "d_ocp_qp_ipm_arg_create");
  find(f.arg_set_default, "d_ocp_qp_ipm_arg_set_default");
  find(f.arg_set, "d_ocp_qp_ipm_arg_set");
  find(f.ws_strsize, "d_ocp_qp_ipm_ws_strsize");
  find(f.ws_memsize, "d_ocp_qp_ipm_ws_memsize");
  find(f.ws_create, "d_ocp_qp_ipm_ws_create");
  find(f.get, "d_ocp_qp_ipm_get");
  find(f.solve, "d_ocp_qp_ipm_solve");
  f.lg_mask = dlsym(handle_, "d_ocp_qp_set_lg_mask");
  f.sol_set_pi = dlsym(handle_, "d_ocp_qp_sol_set_pi");
}

HpipmLibrary::~HpipmLibrary() {
  if (handle_ != nullptr) dlclose(handle_);
}

struct Hpipm::Memory {
  Block dim, dim_memory, qp, qp_memory, sol, sol_memory, arg, arg_memory, ws, ws_memory;
};

Hpipm::Hpipm(const HpipmLibrary& library, const qp::StageQp& program, HpipmMode mode,
             double tolerance)
    : f_(library.functions()), m_(std::make_unique<Memory>()) {
  const int N = program.intervals();
  m_->dim = block(f_.dim_strsize());
  m_->dim_memory = block(f_.dim_memsize(N));
  void* dim = m_->dim.get();
  f_.dim_create(N, dim, m_->dim_memory.get());
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = program.stages[k];
    int rows = 0;
    for (const qp::RowGroup& group : s.groups) rows += group.rows;
    rows_.push_back(rows);
    f_.dim_set("nx", k, k == 0 ? 0 : s.nx, dim);
    f_.dim_set("nu", k, s.nu, dim);
    f_.dim_set("ng", k, rows, dim);
  }
  m_->qp = block(f_.qp_strsize());
  m_->qp_memory = block(f_.qp_memsize(dim));
  f_.qp_create(dim, m_->qp.get(), m_->qp_memory.get());
  m_->sol = block(f_.sol_strsize());
  m_->sol_memory = block(f_.sol_memsize(dim));
  f_.sol_create(dim, m_->sol.get(), m_->sol_memory.get());
  m_->arg = block(f_.arg_strsize());
  m_->arg_memory = block(f_.arg_memsize(dim));
  void* arg = m_->arg.get();
  f_.arg_create(dim, arg, m_->arg_memory.get());
  f_.arg_set_default(static_cast<int>(mode), arg);
  for (const char* of : {"tol_stat", "tol_eq", "tol_ineq", "tol_comp"})
    f_.arg_set(of, &tolerance, arg);
  const int iterations = 100;  // as for our solver
  f_.arg_set("iter_max", &iterations, arg);
  m_->ws = block(f_.ws_strsize());
  m_->ws_memory = block(f_.ws_memsize(dim, arg));
  f_.ws_create(dim, arg, m_->ws.get(), m_->ws_memory.get());
}

Hpipm::~Hpipm() = default;

bool Hpipm::takes_multipliers() const { return f_.sol_set_pi != nullptr; }

void Hpipm::load(const qp::StageQp& qp) {
  const int N = qp.intervals();
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = qp.stages[k];
    const int nx = s.nx, nu = s.nu, rows = rows_[k];
    const auto set = [&](const char* what, const auto& values) {
      if (values.size() > 0) f_.qp_set(what, k, values.data(), m_->qp.get());
    };
    const VectorXd fixed = k == 0 ? VectorXd(qp.start.head(nx)) : VectorXd::Zero(nx);
    const MatrixXd S = s.S.topLeftCorner(nu, nx);
    set("R", MatrixXd(s.R.topLeftCorner(nu, nu)));
    set("r", VectorXd(s.r.head(nu) + S * fixed));
    if (k > 0) {
      set("Q", MatrixXd(s.Q.topLeftCorner(nx, nx)));
      set("S", S);
      set("q", VectorXd(s.q.head(nx)));
    }
    if (k < N) {
      const int next = qp.stages[k + 1].nx;
      const MatrixXd A = s.A.topLeftCorner(next, nx);
      if (k > 0) set("A", A);
      set("B", MatrixXd(s.B.topLeftCorner(next, nu)));
      set("b", VectorXd(s.b.head(next) + A * fixed));
    }
    if (rows == 0) continue;
    MatrixXd C = MatrixXd::Zero(rows, nx), D = MatrixXd::Zero(rows, nu);
    VectorXd lower(rows), upper(rows);
    int row = 0;
    for (const qp::RowGroup& group : s.groups)
      for (int i = 0; i < group.rows; ++i, ++row) {
        for (std::size_t c = 0; c < group.columns.size(); ++c) {
          const int j = group.columns[c];
          (j < nx ? C(row, j) : D(row, j - nx)) = group.M(i, static_cast<int>(c));
        }
        const double shift = C.row(row).dot(fixed);
        lower[row] = group.lower[i] - shift;
        upper[row] = group.upper[i] - shift;
      }
    const auto mask = [](const VectorXd& bound) {
      return VectorXd(bound.unaryExpr([](double b) { return std::isfinite(b) ? 1.0 : 0.0; }));
    };
    const VectorXd lower_mask = mask(lower), upper_mask = mask(upper);
    const double absent = f_.lg_mask != nullptr ? 0.0 : far_away;
    for (int i = 0; i < rows; ++i) {
      if (lower_mask[i] == 0.0) lower[i] = -absent;
      if (upper_mask[i] == 0.0) upper[i] = absent;
    }
    if (k > 0) set("C", C);
    set("D", D);
    set("lg", lower);
    set("ug", upper);
    if (f_.lg_mask == nullptr) continue;
    set("lg_mask", lower_mask);
    set("ug_mask", upper_mask);
  }
}

void Hpipm::start_at(const qp::StageQp& qp, const qp::StagePoint& point) {
  const int N = qp.intervals();
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = qp.stages[k];
    const qp::StagePoint::AtStage& from = point.stages[k];
    if (k > 0) f_.sol_set("x", k, from.x.data(), m_->sol.get());
    if (s.nu > 0) f_.sol_set("u", k, from.u.data(), m_->sol.get());
    if (!takes_multipliers()) continue;
    if (k < N) f_.sol_set("pi", k, from.costate.data(), m_->sol.get());
    if (rows_[k] == 0) continue;
    VectorXd lower(rows_[k]), upper(rows_[k]);
    int row = 0;
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      for (int i = 0; i < s.groups[g].rows; ++i, ++row) {
        lower[row] = std::max(-from.group[g][i], 0.0);
        upper[row] = std::max(from.group[g][i], 0.0);
      }
    f_.sol_set("lam_lg", k, lower.data(), m_->sol.get());
    f_.sol_set("lam_ug", k, upper.data(), m_->sol.get());
  }
}

void Hpipm::solve(Start start) {
  const int warm = static_cast<int>(start);
  f_.arg_set("warm_start", &warm, m_->arg.get());
  f_.solve(m_->qp.get(), m_->sol.get(), m_->arg.get(), m_->ws.get());
}

int Hpipm::iterations() const {
  int count = 0;
  f_.get("iter", m_->ws.get(), &count);
  return count;
}

void Hpipm::read(const qp::StageQp& qp, qp::StagePoint& point) const {
  const int N = qp.intervals();
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = qp.stages[k];
    qp::StagePoint::AtStage& to = point.stages[k];
    const auto get = [&](const char* what, double* values) {
      f_.sol_get(what, k, m_->sol.get(), values);
    };
    if (k == 0)
      to.x.head(s.nx) = qp.start.head(s.nx);
    else
      get("x", to.x.data());
    if (s.nu > 0) get("u", to.u.data());
    if (k < N) get("pi", to.costate.data());
    to.x_bound.setZero();
    to.u_bound.setZero();
    if (rows_[k] == 0) continue;
    VectorXd lower(rows_[k]), upper(rows_[k]);
    get("lam_lg", lower.data());
    get("lam_ug", upper.data());
    int row = 0;
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      for (int i = 0; i < s.groups[g].rows; ++i, ++row)
        to.group[g][i] = (std::isfinite(s.groups[g].upper[i]) ? upper[row] : 0.0) -
                         (std::isfinite(s.groups[g].lower[i]) ? lower[row] : 0.0);
  }
}

}  // namespace saltus::bench
