#include "saltus/solver/presolve.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/solver/well_posed.hpp"

namespace saltus {
namespace {

constexpr double rounding = 1e-13;       // relative to the largest term of a sum
constexpr double smallest_pivot = 1e-6;  // relative to the largest entry of its row
constexpr double same_slopes = 1e-10;    // relative tolerance of rows that are multiples
constexpr double same_side = 1e-9;       // relative tolerance of equal sides
constexpr int most_passes = 10;          // limit of the passes over the equalities
// Rows that an equality implies: relative tolerance of their slopes, at the guess and where the
// equality holds; relative residuals of an equality that nearly holds.
constexpr double roughly_along = 1e-3, along = 1e-8;
constexpr double near_guess = 1e-6, nearly_solved = 1e-11;
constexpr double away_from_guess = 1e-3;  // relative distance of the points that are compared
constexpr int most_rounds = 4, most_newton_steps = 8;
constexpr int no_index = -1;

// value = factor * (value of the root) + offset. The factor of a known variable is 0.
struct Alias {
  int root = no_index;
  double factor = 1.0, offset = 0.0;
};
// A root and its coefficient in a row.
struct Term {
  int root;
  double coefficient;
};
// A row, or the bounds of a variable, as a function of a common quantity: scale * quantity + shift.
struct Member {
  int row = no_index, variable = no_index;
  double scale = 1.0, shift = 0.0;
  double lower = -infinity, upper = infinity;           // bounds of the quantity
  double lower_tolerance = 0.0, upper_tolerance = 0.0;  // tolerances of these bounds
  bool can_go = true;
};

class Analysis {
 public:
  Analysis(NonlinearProgram& program, const PresolveOptions& options)
      : program_(program),
        options_(options),
        pattern_(program.jacobian_pattern()),
        n_(program.variables()),
        m_(program.rows()),
        alias_(n_),
        joined_by_(n_, no_index),
        known_by_(n_, no_index),
        defines_(m_, 0),
        is_kept_(m_, 0) {
    result_.lower = program.lower();
    result_.upper = program.upper();
    result_.row_lower = program.row_lower();
    result_.row_upper = program.row_upper();
    const auto relax = [&](VectorXd& lower, VectorXd& upper) {
      for (int i = 0; i < lower.size(); ++i) {
        const Bounds given{lower[i], upper[i]}, b = without_sentinels(given);
        if (b == given || b.is_empty()) continue;
        lower[i] = b.lower;
        upper[i] = b.upper;
        result_.has_changed = true;
      }
    };
    relax(result_.lower, result_.upper);
    relax(result_.row_lower, result_.row_upper);
    for (int i = 0; i < n_; ++i) alias_[i].root = i;
  }

  Presolve look_at(const VectorXd& w) {
    if (w.size() != n_ || !w.allFinite()) return std::move(result_);
    const VectorXd inside = w.cwiseMax(result_.lower).cwiseMin(result_.upper);
    if (!evaluate(inside, at_)) return std::move(result_);
    keep_stages();
    for (int i = 0; i < n_; ++i)
      if (result_.lower[i] == result_.upper[i]) know(i, result_.lower[i], no_index);
    find_aliases();
    if (result_.contradiction) return std::move(result_);
    const VectorXd consistent = made_consistent(inside);
    if (consistent != inside && !evaluate(consistent, at_)) return std::move(result_);
    settle_constant_rows();
    if (!result_.contradiction) compare_rows();
    return std::move(result_);
  }

 private:
  struct Evaluation {
    VectorXd w, rows;
    std::vector<double> entries;
  };

  bool evaluate(const VectorXd& w, Evaluation& at) {
    at.w = w;
    at.rows.resize(m_);
    at.entries.resize(pattern_.entries());
    if (!program_.jacobian(w.data(), at.entries.data()) ||
        !program_.constraints(w.data(), at.rows.data()))
      return false;
    return at.rows.allFinite() &&
           std::ranges::all_of(at.entries, [](double e) { return std::isfinite(e); });
  }

  bool is_on(int r) const {
    return result_.row_lower[r] > -infinity || result_.row_upper[r] < infinity;
  }
  Bounds sides(int r) const { return {result_.row_lower[r], result_.row_upper[r]}; }

  void keep_stages() {
    if (!options_.keeps_stages) return;
    try {
      const qp::StageStructure structure = program_.stages();
      for (const int r : structure.start_rows) is_kept_[r] = 1;
      for (const qp::StageStructure::Stage& stage : structure.stages)
        for (const int r : stage.dynamics) is_kept_[r] = 1;
    } catch (const DefinitionError&) {  // no stages; the solver reports it
    }
  }

  // --- known and merged variables ----------------------------------------------------------------
  Alias resolved(int v) {
    Alias a = alias_[v];
    while (a.factor != 0.0 && alias_[a.root].root != a.root) {
      const Alias& next = alias_[a.root];
      a = {next.root, a.factor * next.factor, a.factor * next.offset + a.offset};
    }
    if (a.factor != 0.0 && alias_[a.root].factor == 0.0)  // the root has become known
      a = {a.root, 0.0, a.factor * alias_[a.root].offset + a.offset};
    return alias_[v] = a;
  }
  bool is_known(int v) { return resolved(v).factor == 0.0; }
  void know(int root, double value, int row) {
    alias_[root] = {root, 0.0, value};
    known_by_[root] = row;
  }

  // Writes a row as a sum over roots and returns its constant. Sets has_tiny_term_ if a coefficient
  // is at the rounding level of the row. In other units, the variable may be large enough to make
  // the term significant. Therefore nothing can be concluded from such a row.
  double reduce(int r, std::vector<Term>& terms) {
    terms.clear();
    has_tiny_term_ = false;
    double constant = at_.rows[r], largest = 0.0;
    for (int e = pattern_.row_begin(r); e < pattern_.row_end(r); ++e) {
      const int v = pattern_.col(e);
      const double c = at_.entries[e];
      if (c == 0.0) continue;
      largest = std::max(largest, std::abs(c));
      const Alias a = resolved(v);
      constant += c * (a.offset - at_.w[v]);
      if (a.factor != 0.0) terms.push_back({a.root, c * a.factor});
    }
    std::ranges::sort(terms, {}, &Term::root);
    std::size_t count = 0;
    for (std::size_t i = 0; i < terms.size();) {
      Term sum{terms[i].root, 0.0};
      double size = 0.0;
      for (; i < terms.size() && terms[i].root == sum.root; ++i) {
        sum.coefficient += terms[i].coefficient;
        size += std::abs(terms[i].coefficient);
      }
      if (std::abs(sum.coefficient) <= rounding * size) continue;  // the terms cancel
      if (std::abs(sum.coefficient) <= rounding * largest) has_tiny_term_ = true;
      terms[count++] = sum;
    }
    terms.resize(count);
    return constant;
  }

  void find_aliases() {
    std::vector<int> open;
    for (int r = 0; r < m_; ++r)
      if (result_.row_lower[r] == result_.row_upper[r] && program_.is_affine(r)) open.push_back(r);
    std::vector<Term> terms;
    for (int pass = 0; pass < most_passes; ++pass) {
      const auto is_used = [&](int r) {
        const double constant = reduce(r, terms);
        if (has_tiny_term_) return false;
        double largest = 0.0;
        for (const Term& t : terms) largest = std::max(largest, std::abs(t.coefficient));
        const auto is_pivot = [&](const Term& t) {
          return std::abs(t.coefficient) >= smallest_pivot * largest;
        };
        if (terms.size() == 1) {
          const Term& t = terms.front();
          const int source = single_source(r);
          know(t.root, (result_.row_lower[r] - constant) / t.coefficient,
               source == no_index ? r : source);
        } else if (terms.size() == 2 && is_pivot(terms[0]) && is_pivot(terms[1])) {
          const Term &kept = terms[0], &gone = terms[1];
          alias_[gone.root] = {kept.root, -kept.coefficient / gone.coefficient,
                               (result_.row_lower[r] - constant) / gone.coefficient};
          joined_by_[gone.root] = r;
        } else {
          return false;
        }
        defines_[r] = 1;
        return true;
      };
      if (std::erase_if(open, is_used) == 0) break;
    }
    // Compares values that rows give to variables with their bounds.
    for (int v = 0; v < n_; ++v) {
      const Alias a = resolved(v);
      const Bounds b{result_.lower[v], result_.upper[v]};
      const double miss = std::max(b.lower - a.offset, a.offset - b.upper);
      const double relative = violation_in_tolerances(b, a.offset);
      if (a.factor == 0.0 && relative > 1.0)
        note({.row = known_by_[a.root], .variable = v, .amount = miss}, relative);
    }
  }

  VectorXd made_consistent(const VectorXd& w) {
    VectorXd result(n_);
    for (int v = 0; v < n_; ++v) {
      const Alias a = resolved(v);
      result[v] = a.factor == 0.0 ? a.offset : a.factor * w[a.root] + a.offset;
      if (a.factor == 1.0 && a.offset == 0.0 && a.root == v) result[v] = w[v];
    }
    return result;
  }

  // --- constant rows ------------------------------------------------------------------------
  void note(const NlpResult::Contradiction& found, double relative) {
    if (relative <= worst_) return;
    worst_ = relative;
    result_.contradiction = found;
  }

  void leave_out(int r) {
    result_.row_lower[r] = -infinity;
    result_.row_upper[r] = infinity;
    result_.has_changed = true;
  }

  void settle_constant_rows() {
    std::vector<Term> terms;
    for (int r = 0; r < m_; ++r) {
      if (!is_on(r) || defines_[r]) continue;
      double value = at_.rows[r];
      if (program_.is_affine(r)) {
        value = reduce(r, terms);
        if (!terms.empty()) continue;
      } else if (has_unknown(r)) {
        continue;
      }
      const Bounds b = sides(r);
      const double miss = std::max(b.lower - value, value - b.upper);
      const double relative = violation_in_tolerances(b, value);
      if (relative > 1.0)
        note({.row = r, .other_row = cause(r), .amount = miss}, relative);
      else if (!is_kept_[r])
        leave_out(r);
    }
  }

  bool has_unknown(int r) {
    for (int e = pattern_.row_begin(r); e < pattern_.row_end(r); ++e)
      if (!is_known(pattern_.col(e))) return true;
    return false;
  }

  // Rows that determine all variables of a row.
  std::vector<int> sources(int r) {
    std::vector<int> all;
    for (int e = pattern_.row_begin(r); e < pattern_.row_end(r); ++e) {
      if (at_.entries[e] == 0.0) continue;
      const int v = pattern_.col(e);
      const Alias a = resolved(v);
      const int by = a.factor == 0.0 ? known_by_[a.root] : joined_by_[v];
      if (by != no_index) all.push_back(by);
    }
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  // Source of a row that passes on a value unchanged, such as a jump.
  int single_source(int r) {
    const std::vector<int> all = sources(r);
    return all.size() == 1 && result_.row_lower[r] == 0.0 ? all.front() : no_index;
  }
  // Row to name together with a contradictory row. Of several candidates the last one is chosen
  // because the first rows of a program are those of its start.
  int cause(int r) {
    const std::vector<int> all = sources(r);
    return all.empty() ? no_index : all.back();
  }

  // --- rows that are multiples of each other -----------------------------------------------------
  void compare_rows() {
    std::map<std::vector<int>, std::vector<int>> affine, nonlinear;
    std::vector<Term> terms;
    std::vector<int> key;
    for (int r = 0; r < m_; ++r) {
      if (!is_on(r) || defines_[r]) continue;
      const bool is_affine = program_.is_affine(r);
      if (!is_affine && !options_.compares_nonlinear) continue;
      key.clear();
      if (is_affine) {
        reduce(r, terms);
        for (const Term& t : terms) key.push_back(t.root);
        if (key.empty() || has_tiny_term_) continue;
      } else {
        for (int e = pattern_.row_begin(r); e < pattern_.row_end(r); ++e)
          if (!is_known(pattern_.col(e))) key.push_back(resolved(pattern_.col(e)).root);
        std::ranges::sort(key);
        key.erase(std::unique(key.begin(), key.end()), key.end());
      }
      (is_affine ? affine : nonlinear)[key].push_back(r);
    }
    // Bounds of a variable act as a row on it that is always kept.
    std::map<int, std::vector<int>> bounded;
    for (int v = 0; v < n_; ++v)
      if (!is_known(v) && (result_.lower[v] > -infinity || result_.upper[v] < infinity))
        bounded[resolved(v).root].push_back(v);
    for (const auto& [roots, rows] : affine) compare_affine(roots, rows, bounded);
    for (const auto& [root, variables] : bounded)
      if (!affine.contains({root})) compare_affine({root}, {}, bounded);
    const std::vector<Pair> pairs = pairs_of(nonlinear);
    std::vector<std::vector<int>> repeated;
    for (const auto& [roots, rows] : nonlinear)
      if (may_repeat(rows)) repeated.push_back(rows);
    if (!repeated.empty() && move_points())
      for (const std::vector<int>& rows : repeated) compare_nonlinear(rows);
    leave_out_implied(pairs);
  }

  Member member(int r, double scale, double shift) const {
    Member m{.row = r, .scale = scale, .shift = shift, .can_go = !is_kept_[r]};
    set_sides(m, sides(r));
    return m;
  }
  static void set_sides(Member& m, const Bounds& b) {
    m.lower = (b.lower - m.shift) / m.scale;
    m.upper = (b.upper - m.shift) / m.scale;
    m.lower_tolerance = bound_tolerance(b.lower) / std::abs(m.scale);
    m.upper_tolerance = bound_tolerance(b.upper) / std::abs(m.scale);
    if (m.scale < 0.0) {
      std::swap(m.lower, m.upper);
      std::swap(m.lower_tolerance, m.upper_tolerance);
    }
  }

  void compare_affine(const std::vector<int>& roots, const std::vector<int>& rows,
                      const std::map<int, std::vector<int>>& bounded) {
    const auto bounds = roots.size() == 1 ? bounded.find(roots.front()) : bounded.end();
    if (rows.size() < 2 && bounds == bounded.end()) return;
    struct Direction {
      std::vector<double> slopes;
      std::vector<Member> members;
    };
    std::vector<Direction> directions;
    std::vector<Term> terms;
    for (const int r : rows) {
      const double constant = reduce(r, terms);
      const double first = terms.front().coefficient;
      std::vector<double> slopes;
      for (const Term& t : terms) slopes.push_back(t.coefficient / first);
      const auto known = std::ranges::find_if(
          directions, [&](const Direction& d) { return are_same(d.slopes, slopes); });
      Direction& to = known != directions.end() ? *known : directions.emplace_back();
      if (to.members.empty()) to.slopes = std::move(slopes);
      to.members.push_back(member(r, first, constant));
    }
    if (bounds != bounded.end()) {
      Direction& to = directions.empty() ? directions.emplace_back() : directions.front();
      for (const int v : bounds->second) {
        const Alias a = resolved(v);
        Member m{.variable = v, .scale = a.factor, .shift = a.offset, .can_go = false};
        set_sides(m, {result_.lower[v], result_.upper[v]});
        to.members.push_back(m);
      }
    }
    for (Direction& d : directions) keep_tightest(d.members);
  }

  static bool are_same(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
      largest = std::max({largest, std::abs(a[i]), std::abs(b[i])});
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i] - b[i]) > same_slopes * largest) return false;
    return true;
  }

  // Slopes of a row along the roots, in their order.
  std::vector<double> slopes(int r, const Evaluation& at) {
    std::map<int, double> sums;
    for (int e = pattern_.row_begin(r); e < pattern_.row_end(r); ++e) {
      const Alias a = resolved(pattern_.col(e));
      if (a.factor != 0.0) sums[a.root] += a.factor * at.entries[e];
    }
    std::vector<double> result;
    for (const auto& [root, slope] : sums) result.push_back(slope);
    return result;
  }

  // Factor of a relative to b; 0 if they are not multiples of each other.
  static double multiple(const std::vector<double>& a, const std::vector<double>& b) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i]) > std::abs(a[at])) at = i;
    if (a.empty() || a[at] == 0.0 || b[at] == 0.0) return 0.0;
    const double factor = b[at] / a[at];
    std::vector<double> scaled = a;
    for (double& s : scaled) s *= factor;
    return are_same(scaled, b) ? factor : 0.0;
  }

  // True if at the first point two rows are multiples, or two have zero slopes.
  bool may_repeat(const std::vector<int>& rows) {
    if (rows.size() < 2) return false;
    std::vector<std::vector<double>> all;
    for (const int r : rows) all.push_back(slopes(r, at_));
    const auto is_flat = [](const std::vector<double>& a) {
      return std::ranges::all_of(a, [](double s) { return s == 0.0; });
    };
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i + 1; j < all.size(); ++j)
        if (multiple(all[i], all[j]) != 0.0 || (is_flat(all[i]) && is_flat(all[j]))) return true;
    return false;
  }

  bool move_points() {
    Random random(1);
    for (Evaluation* at : {&first_, &second_})
      if (!evaluate(made_consistent(moved(at_.w, random)), *at)) return false;
    return true;
  }
  static VectorXd moved(VectorXd w, Random& random) {
    for (double& x : w)
      x += away_from_guess * std::max(1.0, std::abs(x)) * random.uniform(-1.0, 1.0);
    return w;
  }

  void compare_nonlinear(const std::vector<int>& rows) {
    std::vector<char> is_taken(rows.size(), 0);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (is_taken[i]) continue;
      std::vector<Member> members{member(rows[i], 1.0, 0.0)};
      const std::vector<double> a1 = slopes(rows[i], first_), a2 = slopes(rows[i], second_);
      for (std::size_t j = i + 1; j < rows.size(); ++j) {
        if (is_taken[j]) continue;
        const double factor = multiple(a1, slopes(rows[j], first_));
        const double again = multiple(a2, slopes(rows[j], second_));
        if (factor == 0.0 || std::abs(factor - again) > same_slopes * std::abs(factor)) continue;
        const auto shift = [&](const Evaluation& at) {
          return at.rows[rows[j]] - factor * at.rows[rows[i]];
        };
        const double size = std::max(1.0, std::abs(first_.rows[rows[j]]));
        if (std::abs(shift(first_) - shift(second_)) > same_slopes * size) continue;
        is_taken[j] = 1;
        members.push_back(member(rows[j], factor, shift(first_)));
      }
      keep_tightest(members);
    }
  }

  // --- rows that an equality implies -------------------------------------------------------------
  // On the set where x^2 + y^2 = 1 holds, sqrt(x^2 + y^2) is constant, although the two rows are
  // not multiples of each other elsewhere. A row is implied by an equality with the same unknowns
  // if, at points of that set, its sides hold and its slopes are a multiple of those of the
  // equality.
  struct Pair {
    int equality, row;
    const std::vector<int>* roots;  // key in the map of rows
    double size;                    // largest slope of the row seen so far
  };

  // Candidates. A guess that meets the equality decides for most pairs.
  std::vector<Pair> pairs_of(const std::map<std::vector<int>, std::vector<int>>& buckets) {
    std::vector<Pair> pairs;
    for (const auto& [roots, rows] : buckets)
      for (const int e : rows) {
        if (sides(e).lower != sides(e).upper) continue;
        for (const int r : rows) {
          if (r == e || is_kept_[r]) continue;
          const std::vector<double> a = slopes(r, at_);
          Pair pair{e, r, &roots, largest_of(a)};
          if (std::abs(miss_of(e, at_)) <= near_guess && !is_along(pair, at_, roughly_along))
            continue;
          pairs.push_back(pair);
        }
      }
    return pairs;
  }

  static double largest_of(const std::vector<double>& a) {
    double largest = 0.0;
    for (const double x : a) largest = std::max(largest, std::abs(x));
    return largest;
  }
  static double product(const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  }
  // Residual of an equality relative to its side.
  double miss_of(int equality, const Evaluation& at) const {
    const double side = result_.row_lower[equality];
    return (at.rows[equality] - side) / std::max(1.0, std::abs(side));
  }

  // True if the slopes of the row are a multiple of those of the equality, or zero.
  bool is_along(Pair& pair, const Evaluation& at, double tolerance) {
    const std::vector<double> a = slopes(pair.equality, at), b = slopes(pair.row, at);
    const double aa = product(a, a), ab = product(a, b);
    if (!(aa > 0.0)) return false;
    pair.size = std::max(pair.size, largest_of(b));
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(b[i] - ab / aa * a[i]) > tolerance * pair.size) return false;
    return true;
  }
  bool holds_at(int r, const Evaluation& at) const {
    const auto miss = [&](double side, double by) {
      return by > same_side * std::max(1.0, std::abs(side));
    };
    const Bounds b = sides(r);
    return !miss(b.lower, b.lower - at.rows[r]) && !miss(b.upper, at.rows[r] - b.upper);
  }

  void leave_out_implied(std::vector<Pair> open) {
    for (int round = 0; round < most_rounds && !open.empty(); ++round) {
      // Equalities of one round share no unknowns, so that each is solved separately.
      std::map<int, int> equality_of;  // per root
      std::vector<Pair> pairs, later;
      for (const Pair& pair : open) {
        if (!is_on(pair.row) || !is_on(pair.equality)) continue;
        const bool is_free = std::ranges::all_of(*pair.roots, [&](int root) {
          const auto at = equality_of.find(root);
          return at == equality_of.end() || at->second == pair.equality;
        });
        (is_free ? pairs : later).push_back(pair);
        if (is_free)
          for (const int root : *pair.roots) equality_of[root] = pair.equality;
      }
      Random random(1);
      keep_implied(at_.w, pairs);
      for (int point = 0; point < 2 && !pairs.empty(); ++point)
        keep_implied(moved(at_.w, random), pairs);
      for (const Pair& pair : pairs) {
        if (!is_on(pair.row) || !is_on(pair.equality)) continue;
        leave_out(pair.row);
        result_.nonlinear.push_back(pair.row);
      }
      open = std::move(later);
    }
  }

  // Removes pairs that a point disproves: one near w where their equalities hold.
  void keep_implied(VectorXd w, std::vector<Pair>& pairs) {
    for (int step = 0;; ++step) {
      if (!evaluate(made_consistent(w), first_)) return pairs.clear();
      if (step == most_newton_steps) break;
      bool is_solved = true;
      int last = no_index;
      for (const Pair& pair : pairs) {
        if (pair.equality == last || std::abs(miss_of(pair.equality, first_)) <= rounding) continue;
        last = pair.equality;
        is_solved = false;
        const std::vector<double> a = slopes(pair.equality, first_);
        const double aa = product(a, a);
        const double miss = first_.rows[pair.equality] - result_.row_lower[pair.equality];
        if (aa > 0.0)
          for (std::size_t i = 0; i < a.size(); ++i) w[(*pair.roots)[i]] -= miss / aa * a[i];
      }
      if (is_solved) break;
    }
    std::erase_if(pairs, [&](Pair& pair) {
      return std::abs(miss_of(pair.equality, first_)) > nearly_solved ||
             !holds_at(pair.row, first_) || !is_along(pair, first_, along);
    });
  }

  // Keeps the largest lower side and the smallest upper side.
  void keep_tightest(std::vector<Member>& members) {
    if (members.size() < 2) return;
    double lower = -infinity, upper = infinity;
    for (const Member& m : members) {
      lower = std::max(lower, m.lower);
      upper = std::min(upper, m.upper);
    }
    const auto is_at = [](double side, double tightest) {
      return side == tightest ||
             std::abs(side - tightest) <= same_side * std::max(1.0, std::abs(tightest));
    };
    // prefers members that are kept anyway, then those with both sides
    const auto holds = [&](bool is_lower) {
      const Member* best = nullptr;
      int most = -1;
      for (const Member& m : members) {
        const bool has_lower = is_at(m.lower, lower), has_upper = is_at(m.upper, upper);
        if (!(is_lower ? has_lower : has_upper)) continue;
        const int rank = (m.can_go ? 0 : 2) + (has_lower && has_upper ? 1 : 0);
        if (rank > most) best = &m;
        most = std::max(most, rank);
      }
      return best;
    };
    const Member *low = holds(true), *high = holds(false);
    if (lower - upper > low->lower_tolerance + high->upper_tolerance) {
      contradict(*low, *high, lower - upper);
      return;
    }
    if (lower > upper)  // equalities that differ by less than their tolerances: one suffices
      for (const Member* m : {low, high})
        if (m->lower == m->upper) low = high = m;
    for (const Member& m : members) {
      if (!m.can_go) continue;
      const bool is_equality = result_.row_lower[m.row] == result_.row_upper[m.row];
      const bool is_low = &m == low || m.lower == -infinity;
      const bool is_high = &m == high || m.upper == infinity;
      if (is_low && is_high) continue;
      if (is_equality && (&m == low || &m == high)) continue;
      // The side of the row that corresponds to the side of the quantity.
      const bool flips = m.scale < 0.0;
      VectorXd& row_lower = flips ? result_.row_upper : result_.row_lower;
      VectorXd& row_upper = flips ? result_.row_lower : result_.row_upper;
      if (&m != low) row_lower[m.row] = flips ? infinity : -infinity;
      if (&m != high) row_upper[m.row] = flips ? -infinity : infinity;
      result_.has_changed = true;
      if (!program_.is_affine(m.row)) result_.nonlinear.push_back(m.row);
    }
  }

  void contradict(const Member& low, const Member& high, double gap) {
    const Member& row = high.row >= 0 ? high : low;
    const Member& other = high.row >= 0 ? low : high;
    const double amount = gap * std::abs(row.scale);
    const double relative = gap / (&row == &high ? high.upper_tolerance : low.lower_tolerance);
    if (row.row >= 0)
      note({.row = row.row, .other_row = other.row, .variable = other.variable, .amount = amount},
           relative);
    else  // bounds of two merged variables
      note({.row = no_index, .variable = row.variable, .amount = amount}, relative);
  }

  NonlinearProgram& program_;
  PresolveOptions options_;
  const SparsityPattern& pattern_;
  int n_, m_;
  Presolve result_;
  std::vector<Alias> alias_;
  std::vector<int> joined_by_;  // per merged variable: the row that merges it
  std::vector<int> known_by_;   // per root: the row that determines it
  std::vector<char> defines_;   // rows that determine a variable or merge two
  std::vector<char> is_kept_;   // rows that define stages
  Evaluation at_, first_, second_;
  double worst_ = 0.0;          // largest contradiction, relative to its tolerance
  bool has_tiny_term_ = false;  // see reduce()
};

}  // namespace

Presolve presolve(NonlinearProgram& program, const VectorXd& w, const PresolveOptions& options) {
  return Analysis(program, options).look_at(w);
}

namespace {

ScaledResult contradicted(NonlinearProgram& program, const NlpPoint& start, const Presolve& sides) {
  ScaledResult result;
  NlpResult& nlp = result.nlp;
  nlp.status = SolveStatus::infeasible;
  nlp.contradiction = sides.contradiction;
  nlp.point = {start.w.cwiseMax(sides.lower).cwiseMin(sides.upper), VectorXd::Zero(program.rows()),
               VectorXd::Zero(program.variables())};
  nlp.hessian = "no";
  if (!program.objective(nlp.point.w.data(), nlp.objective)) nlp.objective = 0.0;
  nlp.kkt = result.in_scale = kkt_residual(program, nlp.point);
  return result;
}

// Sets the multipliers of removed sides to zero.
void give_multipliers(const Presolve& sides, NlpPoint& point) {
  const auto clear = [](const VectorXd& lower, const VectorXd& upper, VectorXd& multipliers) {
    for (int i = 0; i < multipliers.size(); ++i) {
      if (lower[i] == -infinity) multipliers[i] = std::max(multipliers[i], 0.0);
      if (upper[i] == infinity) multipliers[i] = std::min(multipliers[i], 0.0);
    }
  };
  if (point.lambda.size() == sides.row_lower.size())
    clear(sides.row_lower, sides.row_upper, point.lambda);
  if (point.z.size() == sides.lower.size()) clear(sides.lower, sides.upper, point.z);
}

bool holds(NonlinearProgram& program, const std::vector<int>& rows, const VectorXd& w) {
  VectorXd values(program.rows());
  if (rows.empty() || !program.constraints(w.data(), values.data())) return true;
  return std::ranges::all_of(rows, [&](int r) {
    const Bounds b{program.row_lower()[r], program.row_upper()[r]};
    return violation_in_tolerances(b, values[r]) <= 1.0;
  });
}

}  // namespace

ScaledResult solve_presolved(const Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             const std::function<ScaledResult(NonlinearProgram&)>& solve) {
  if (!is_well_posed(program, start)) return solve(program);
  int iterations = 0;
  double seconds = 0.0;
  for (const bool compares_nonlinear : {true, false}) {
    const WallClock::time_point begin = WallClock::now();
    const Presolve sides =
        presolve(program, start.w,
                 {.keeps_stages = solver.keeps_stages(), .compares_nonlinear = compares_nonlinear});
    if (sides.contradiction) return contradicted(program, start, sides);
    seconds += seconds_since(begin);
    PresolvedProgram reduced(program, sides);
    ScaledResult result = sides.has_changed ? solve(reduced) : solve(program);
    iterations = result.nlp.iterations += iterations;
    seconds = result.nlp.seconds += seconds;
    if (!sides.has_changed) return result;
    give_multipliers(sides, result.nlp.point);
    result.nlp.kkt = kkt_residual(program, result.nlp.point);
    // Rows that were multiples near the start may differ elsewhere.
    if (!is_success(result.nlp.status) || holds(program, sides.nonlinear, result.nlp.point.w))
      return result;
  }
  return {};  // the second call compares no rows and returns
}

}  // namespace saltus
