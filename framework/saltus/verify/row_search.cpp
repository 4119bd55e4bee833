#include "saltus/verify/row_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {
namespace {

constexpr double thinnest = 1e-10;  // fraction of a step
constexpr double share = 0.1;       // fraction of a tolerance: smaller violations may be missed
constexpr double within = 1.001;    // times the largest found: larger bounds are searched
constexpr int first_samples = 8;    // per step, of a function without elementary steps
constexpr int deepest = 14;         // bisections of the distance between samples

// Maximum of v + s d + c d^2 / 2 over |d| <= r, and its position.
std::pair<double, double> parabola(double v, double s, double c, double r) {
  if (!std::isfinite(s) || !std::isfinite(c)) return {infinity, 0.0};
  double at = s >= 0.0 ? r : -r;
  if (c < 0.0) at = std::clamp(-s / c, -r, r);
  return {v + at * (s + 0.5 * c * at), at};
}

}  // namespace

void RowSearch::look_at(PlanField& field, const ControlledSteps& steps, double end) {
  end_ = end;
  field_ = &field;
  steps_ = &steps;
  box_.resize(field.sizes().size());
  point_.resize(field.sizes().size());
  x_.resize(field.outputs());
}

double RowSearch::time_at(double theta) const {
  return field_->start() +
         field_->length() * (steps_->step_start() + theta * steps_->step_length());
}

double RowSearch::limit(double tolerance, double found) const {
  return std::max(std::min(share * tolerance, resolution_), within * found);
}

void RowSearch::note(PathRow& row, double value, double theta) const {
  if (!std::isfinite(value)) {
    row.lower_found = row.upper_found = infinity;
    row.lower_time = row.upper_time = time_at(theta);
    return;
  }
  row.least = std::min(row.least, value);
  row.most = std::max(row.most, value);
  if (row.bounds.lower - value > row.lower_found) {
    row.lower_found = row.bounds.lower - value;
    row.lower_time = time_at(theta);
  }
  if (value - row.bounds.upper > row.upper_found) {
    row.upper_found = value - row.bounds.upper;
    row.upper_time = time_at(theta);
  }
}

double RowSearch::fraction_at(double time) const {
  return ((time - field_->start()) / field_->length() - steps_->step_start()) /
         steps_->step_length();
}

bool RowSearch::search(PathConstraint& constraint, int most_pieces) {
  return constraint.formula ? bound(constraint, most_pieces) : sample(constraint);
}

// Derivatives are with respect to theta.
void RowSearch::fill(const std::vector<int>& arguments, double middle, double radius) {
  const Arguments& a = field_->sizes();
  const double step = steps_->step_length();
  const Interval d{-radius, radius}, d2{0.0, radius * radius},
      d3{-radius * radius * radius, radius * radius * radius},
      d4{0.0, radius * radius * radius * radius};
  const auto scaled = [](double factor, const Interval& by) {
    return factor >= 0.0 ? Interval{factor * by.lower, factor * by.upper}
                         : Interval{factor * by.upper, factor * by.lower};
  };
  const auto sum = [](double value, std::initializer_list<Interval> parts) {
    Interval total = value;
    for (const Interval& part : parts) {
      total.lower += part.lower;
      total.upper += part.upper;
    }
    return total;
  };
  for (const int z : arguments) {
    if (z == a.t()) {
      const double rate = field_->length() * step;
      point_[z] = {time_at(middle), rate, 0.0};
      box_[z] = {sum(point_[z].value, {scaled(rate, d)}), rate, 0.0};
    } else if (z < a.u()) {
      const int i = z - a.x();
      double c[5];
      for (int k = 0; k < 5; ++k) c[k] = steps_->coefficient(k)[i];
      // Coefficients of the expansion around the middle.
      for (int from = 0; from < 4; ++from)
        for (int k = 3; k >= from; --k) c[k] += middle * c[k + 1];
      point_[z] = {c[0], c[1], 2.0 * c[2]};
      box_[z].value =
          sum(c[0], {scaled(c[1], d), scaled(c[2], d2), scaled(c[3], d3), scaled(c[4], d4)});
      box_[z].first =
          sum(c[1], {scaled(2.0 * c[2], d), scaled(3.0 * c[3], d2), scaled(4.0 * c[4], d3)});
      box_[z].second = sum(2.0 * c[2], {scaled(6.0 * c[3], d), scaled(12.0 * c[4], d2)});
    } else if (z < a.p()) {
      const int i = z - a.u();
      const double rate = field_->input_change(i) * step;
      const double s = steps_->step_start() + middle * step;
      point_[z] = {field_->input_at_start(i) + s * field_->input_change(i), rate, 0.0};
      box_[z] = {sum(point_[z].value, {scaled(rate, d)}), rate, 0.0};
    } else {
      const double value = field_->parameter(z - a.p());
      point_[z] = {value, 0.0, 0.0};
      box_[z] = {value, 0.0, 0.0};
    }
  }
}

bool RowSearch::bound(PathConstraint& constraint, int most_pieces) {
  FormulaBounds& formula = *constraint.formula;
  std::vector<std::pair<double, double>> pieces{{0.0, end_}};
  int looked_at = 0;
  const auto has_value = [&] {
    for (int i = 0; i < formula.outputs(); ++i)
      if (!std::isfinite(formula.at(i).value)) return false;
    return true;
  };
  // At the edge of its domain, rounding may make a formula NaN. It is then evaluated nearby.
  const auto note_all = [&](double theta) {
    constexpr double beside = 1e-6;  // fraction of a step
    for (const double other : {std::max(0.0, theta - beside), std::min(end_, theta + beside)}) {
      if (has_value()) break;
      fill(constraint.arguments, other, 0.0);
      formula.evaluate(point_);
    }
    for (std::size_t i = 0; i < constraint.rows.size(); ++i)
      note(constraint.rows[i], formula.at(static_cast<int>(i)).value, theta);
  };
  for (const double theta : {0.0, end_}) {
    fill(constraint.arguments, theta, 0.0);
    formula.evaluate(point_);
    note_all(theta);
  }
  while (!pieces.empty()) {
    if (++looked_at > most_pieces) return false;
    const auto [begin, end] = pieces.back();
    pieces.pop_back();
    const double middle = 0.5 * (begin + end), radius = 0.5 * (end - begin);
    fill(constraint.arguments, middle, radius);
    formula.evaluate(box_);
    formula.evaluate(point_);
    note_all(middle);
    double most = 0.0, candidate = middle;  // largest possible excess of the limit
    const auto consider = [&](double v, double slope, double curvature, double over_all,
                              double steepest, double allowed) {
      if (over_all <= allowed) return;
      const auto [top, at] = parabola(v, slope, curvature, radius);
      const double hidden = std::min({over_all, v + steepest * radius, top}) - allowed;
      if (!(hidden > most)) return;
      most = hidden;
      candidate = middle + at;
    };
    const auto consider_all = [&] {
      most = 0.0;
      for (std::size_t i = 0; i < constraint.rows.size(); ++i) {
        const PathRow& row = constraint.rows[i];
        const TimeJet<Interval>& box = formula.bounds(static_cast<int>(i));
        const TimeJet<double>& at = formula.at(static_cast<int>(i));
        const double steepest = std::max(std::abs(box.first.lower), std::abs(box.first.upper));
        if (row.bounds.upper < infinity)
          consider(at.value - row.bounds.upper, at.first, box.second.upper,
                   box.value.upper - row.bounds.upper, steepest,
                   limit(row.upper_between, row.upper_found));
        if (row.bounds.lower > -infinity)
          consider(row.bounds.lower - at.value, -at.first, -box.second.lower,
                   row.bounds.lower - box.value.lower, steepest,
                   limit(row.lower_between, row.lower_found));
      }
    };
    consider_all();
    if (most == 0.0 || radius < thinnest) continue;
    if (candidate != middle) {  // often the maximum itself, so that the search ends
      const double top = candidate;
      const std::vector<TimeJet<double>> kept = point_;
      fill(constraint.arguments, top, 0.0);
      formula.evaluate(point_);
      note_all(top);
      formula.evaluate(kept);
      consider_all();
      if (most == 0.0) continue;
    }
    pieces.emplace_back(begin, middle);
    pieces.emplace_back(middle, end);
  }
  return true;
}

RowSearch::Sample RowSearch::sample_at(PathConstraint& constraint, double theta) {
  const Arguments& a = field_->sizes();
  steps_->state_at(theta, x_.data());
  const double s = steps_->step_start() + theta * steps_->step_length();
  const Function& f = constraint.function;
  const auto rows = constraint.rows.size();
  Sample result{theta, std::vector<double>(rows), std::vector<double>(rows)};
  entries_.resize(f.jacobian_pattern().entries());
  f.jacobian(field_->argument(s, x_.data()), result.value.data(), entries_.data());
  f.jacobian_pattern().for_each([&](int row, int z, int e) {
    double rate = 0.0;
    if (z == a.t()) {
      rate = field_->length() * steps_->step_length();
    } else if (z < a.u()) {
      for (int k = ControlledSteps::degree; k >= 1; --k)
        rate = rate * theta + k * steps_->coefficient(k)[z - a.x()];
    } else if (z < a.p()) {
      rate = field_->input_change(z - a.u()) * steps_->step_length();
    }
    result.slope[row] += entries_[e] * rate;
  });
  for (std::size_t i = 0; i < rows; ++i) note(constraint.rows[i], result.value[i], theta);
  return result;
}

bool RowSearch::sample(PathConstraint& constraint) {
  Sample before = sample_at(constraint, 0.0);
  bool resolved = true;
  for (int k = 1; k <= first_samples; ++k) {
    Sample next = sample_at(constraint, end_ * k / first_samples);
    resolved = sample_between(constraint, before, next, 0) && resolved;
    before = std::move(next);
  }
  return resolved;
}

bool RowSearch::sample_between(PathConstraint& constraint, const Sample& a, const Sample& b,
                               int depth) {
  constexpr double inside = 0.4721359549995794;  // not in the middle, where symmetry hides errors
  const double h = b.at - a.at;
  const Sample m = sample_at(constraint, a.at + inside * h);
  bool is_predicted = true;
  double top = -1.0, excess = 0.0;
  for (std::size_t i = 0; i < constraint.rows.size(); ++i) {
    PathRow& row = constraint.rows[i];
    if (!std::isfinite(a.value[i] + b.value[i] + m.value[i])) continue;  // already infinite
    const auto hermite = [&](double s) {
      const double r = 1.0 - s;
      return r * r * ((1.0 + 2.0 * s) * a.value[i] + s * h * a.slope[i]) +
             s * s * ((1.0 + 2.0 * r) * b.value[i] - r * h * b.slope[i]);
    };
    const double error = std::abs(hermite(inside) - m.value[i]);
    // Extrema of the cubic are the roots of its derivative.
    const double d = b.value[i] - a.value[i], p = h * a.slope[i], q = h * b.slope[i];
    const double c2 = 3.0 * d - 2.0 * p - q, c3 = p + q - 2.0 * d;
    const double root = std::sqrt(std::max(0.0, c2 * c2 - 3.0 * c3 * p));
    const double w = -(c2 + std::copysign(root, c2));
    for (const double s : {w != 0.0 ? p / w : -1.0, c3 != 0.0 ? w / (3.0 * c3) : -1.0}) {
      if (!(s > 0.0 && s < 1.0)) continue;
      const double v = hermite(s);
      const double over =
          std::max(v + 4.0 * error - row.bounds.upper - limit(row.upper_between, row.upper_found),
                   row.bounds.lower - v + 4.0 * error - limit(row.lower_between, row.lower_found));
      if (over > excess) excess = over, top = s;
    }
    const double near =
        std::max({a.value[i], b.value[i], m.value[i]}) + 4.0 * error - row.bounds.upper;
    const double low =
        row.bounds.lower - std::min({a.value[i], b.value[i], m.value[i]}) + 4.0 * error;
    const double allowed = share * std::min(row.lower_between, row.upper_between);
    if (error > allowed && (near > limit(row.upper_between, row.upper_found) ||
                            low > limit(row.lower_between, row.lower_found)))
      is_predicted = false;
  }
  if (is_predicted) {
    if (top > 0.0) sample_at(constraint, a.at + top * h);
    return true;
  }
  if (depth >= deepest) return false;
  return sample_between(constraint, a, m, depth + 1) && sample_between(constraint, m, b, depth + 1);
}

}  // namespace saltus
