#include "saltus/robots/model/contact_cone.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace saltus::robots {
namespace {

constexpr int corner_rows = 8;

// Entries that are zero in exact arithmetic (cos 90 degrees) are about 1e-16 in floating point.
double without_rounding(double value) { return std::abs(value) < 1e-15 ? 0.0 : value; }

void check_side(const Bounds& side, const char* axis) {
  if (!(side.lower < side.upper) || !std::isfinite(side.lower) || !std::isfinite(side.upper))
    throw DefinitionError(
        fmt::format("contact cone: the foot rectangle is empty along {}, from {} to {} m; give "
                    "finite numbers, the smaller one first",
                    axis, side.lower, side.upper));
}

void check(const ContactCone::Options& o) {
  if (!(o.friction > 0.0) || !std::isfinite(o.friction))
    throw DefinitionError(
        fmt::format("contact cone: the friction coefficient must be positive, not {}", o.friction));
  if (o.edges < 3)
    throw DefinitionError(
        fmt::format("contact cone: a friction pyramid needs at least 3 edges, not {}", o.edges));
  check_side(o.foot.x, "x");
  check_side(o.foot.y, "y");
  if (!(o.torsional_friction >= 0.0) || !std::isfinite(o.torsional_friction))
    throw DefinitionError(fmt::format(
        "contact cone: the torsional friction coefficient must not be negative, but is {} m",
        o.torsional_friction));
  if (!(o.normal_force.lower >= 0.0))
    throw DefinitionError(
        fmt::format("contact cone: the smallest normal force fz_min must not be negative, but is "
                    "{} N: the ground cannot pull",
                    o.normal_force.lower));
  if (o.normal_force.is_empty())
    throw DefinitionError(fmt::format(
        "contact cone: the smallest normal force fz_min = {} N exceeds the largest fz_max = {} N",
        o.normal_force.lower, o.normal_force.upper));
}

}  // namespace

int contact_cone_rows(const ContactCone::Options& options) {
  const int last = !options.normal_force_rows                  ? 0
                   : std::isfinite(options.normal_force.upper) ? 2
                                                               : 1;
  return options.edges + 6 + (options.corners ? corner_rows : 0) + last;
}

ContactCone contact_cone(const ContactCone::Options& options) {
  check(options);
  enum { fx, fy, fz, tx, ty, tz };
  ContactCone cone;
  cone.normal_force = options.normal_force;
  const int rows = contact_cone_rows(options);
  cone.A = MatrixXd::Zero(rows, 6);
  cone.b = VectorXd::Zero(rows);
  cone.names.reserve(rows);

  const double sector = 2.0 * std::numbers::pi / options.edges;
  const double slope = options.pyramid == ContactCone::Pyramid::inscribed
                           ? options.friction * std::cos(0.5 * sector)
                           : options.friction;
  int row = 0;
  for (int i = 0; i < options.edges; ++i, ++row) {
    cone.A(row, fx) = without_rounding(std::cos(i * sector));
    cone.A(row, fy) = without_rounding(std::sin(i * sector));
    cone.A(row, fz) = -slope;
    cone.names.push_back(fmt::format("friction edge {}", i));
  }
  const auto add = [&](const char* name, double on_fz, int column, double sign) {
    cone.A(row, fz) = on_fz;
    cone.A(row, column) = sign;
    cone.names.emplace_back(name);
    ++row;
  };
  add("torsion max", -options.torsional_friction, tz, 1.0);
  add("torsion min", -options.torsional_friction, tz, -1.0);
  add("centre of pressure x min", options.foot.x.lower, ty, 1.0);
  add("centre of pressure x max", -options.foot.x.upper, ty, -1.0);
  add("centre of pressure y min", options.foot.y.lower, tx, -1.0);
  add("centre of pressure y max", -options.foot.y.upper, tx, 1.0);
  if (options.corners) {
    const Bounds &x = options.foot.x, &y = options.foot.y;
    const double X = 0.5 * (x.upper - x.lower), Y = 0.5 * (y.upper - y.lower);
    const double mid_x = 0.5 * (x.lower + x.upper), mid_y = 0.5 * (y.lower + y.upper);
    // Torques about the centre of the rectangle.
    using Row = Eigen::Matrix<double, 1, 6>;
    const Row force[3] = {Row::Unit(fx), Row::Unit(fy), Row::Unit(fz)};
    const Row torque[3] = {Row::Unit(tx) - mid_y * force[2], Row::Unit(ty) + mid_x * force[2],
                           Row::Unit(tz) - mid_x * force[1] + mid_y * force[0]};
    const double mu = options.friction;
    for (const double turn : {1.0, -1.0})
      for (const double first : {1.0, -1.0})
        for (const double second : {1.0, -1.0}) {
          cone.A.row(row) = turn * torque[2] + first * (Y * force[0] + turn * mu * torque[0]) +
                            second * (X * force[1] + turn * mu * torque[1]) -
                            mu * (X + Y) * force[2];
          cone.names.push_back(fmt::format("corners {}{}{}", turn > 0.0 ? '+' : '-',
                                           first > 0.0 ? '+' : '-', second > 0.0 ? '+' : '-'));
          ++row;
        }
  }
  if (row < rows) {
    cone.b[row] = -options.normal_force.lower;
    add("normal force min", -1.0, fz, -1.0);
  }
  if (row < rows) {
    cone.b[row] = options.normal_force.upper;
    add("normal force max", 1.0, fz, 1.0);
  }
  return cone;
}

void ContactCone::check_rows(int m) const {
  if (m != rows())
    throw DefinitionError(
        fmt::format("contact cone: {} rows were requested, but this cone has {}", m, rows()));
}

}  // namespace saltus::robots
