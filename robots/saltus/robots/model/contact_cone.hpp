// Wrenches that a flat rectangular foot can exert on the ground without slipping or tipping.
//
// Wrench w = (fx, fy, fz, tx, ty, tz) in N and Nm, exerted by the ground on the foot, expressed in
// the sole frame, torque about the sole frame's origin, which lies in the contact plane. The centre
// of pressure is (-ty / fz, tx / fz). With friction mu, n edges and x, y the foot rectangle:
//   friction pyramid, inscribed      cos(2 pi i/n) fx + sin(2 pi i/n) fy <= mu cos(pi/n) fz
//   friction pyramid, circumscribed  cos(2 pi i/n) fx + sin(2 pi i/n) fy <= mu fz
//   torsion                          +-tz <= mu_z fz
//   centre of pressure               x_min fz + ty <= 0,  -x_max fz - ty <= 0,
//                                    y_min fz - tx <= 0,  -y_max fz + tx <= 0
//   normal force                     fz_min <= fz <= fz_max
//   corners, if requested, torque about the middle of the rectangle, of half sides X and Y:
//      tz + |Y fx + mu tx| + |X fy + mu ty| <= mu (X + Y) fz
//     -tz + |Y fx - mu tx| + |X fy - mu ty| <= mu (X + Y) fz
// for i = 0 .. n-1. An inscribed pyramid lies inside the Coulomb cone |f_xy| <= mu fz (its edges
// are on the cone), a circumscribed one contains it (its faces touch it): four circumscribed edges
// are |fx|, |fy| <= mu fz.
//
// A separate bound on the torsion admits wrenches that a foot on one corner cannot exert, because
// its only torsion is that of its force. Such a foot turns. The rows `corners` describe the
// wrenches of four corners with |fx|, |fy| <= mu fz each; S. Caron, Q.-C. Pham, Y. Nakamura,
// "Stability of surface contacts for humanoid robots: closed-form formulae of the contact wrench
// cone for rectangular support areas", ICRA 2015.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

/// The set {w : A w <= b}, with rows in the order given at the top of this file.
struct ContactCone {
  /// Pyramid inside the friction cone, or around it.
  enum class Pyramid { inscribed, circumscribed };

  /// Options of contact_cone(). The defaults are the values that the controller of the paper's
  /// first author uses for iCub.
  struct Options {
    double friction = 1.0 / 3.0;           // mu
    int edges = 6;                         // n, at least 3
    Pyramid pyramid = Pyramid::inscribed;  ///< inside the cone, or around it
    FootRectangle foot{};                  // m, in the sole frame
    double torsional_friction = 0.0133;    // mu_z, m: |tz| <= mu_z fz
    bool corners = false;                  // limits the torsion to that of forces at the corners
    Bounds normal_force = between(10.0, 1000.0);  // limits of fz, N
    /// True if fz_min and fz_max appear as the last two rows. Otherwise they appear only as
    /// `ContactCone::normal_force`, for a problem that bounds the input fz itself. An infinite side
    /// never has a row.
    bool normal_force_rows = true;
  };

  MatrixXd A;  // rows x 6; exact zeros where a wrench entry does not appear
  VectorXd b;  // zero except in the rows of the normal force
  /// Names of the rows, such as "friction edge 3", "centre of pressure x max"
  std::vector<std::string> names;
  Bounds normal_force;  // bounds of fz, N

  /// Number of rows.
  int rows() const { return static_cast<int>(b.size()); }

  /// A with m rows at compile time. Throws DefinitionError if m differs from rows().
  template <int m>
  Mat<double, m, 6> fixed() const {
    check_rows(m);
    return A;
  }
  /// b with m rows at compile time. Throws DefinitionError if m differs from rows().
  template <int m>
  Vec<double, m> fixed_bounds() const {
    check_rows(m);
    return b;
  }

  /// The largest violation max(A w - b), in N. The wrench is admissible if it is zero or negative.
  double violation(const Vec<double, 6>& wrench) const { return (A * wrench - b).maxCoeff(); }

 private:
  void check_rows(int m) const;
};

/// Builds the cone. Throws DefinitionError, one sentence naming the option, for friction or torsion
/// that are not positive (torsion may be zero), fewer than 3 edges, an empty rectangle, fz_min < 0,
/// fz_min > fz_max, and any NaN.
ContactCone contact_cone(const ContactCone::Options& options = {});

/// Number of rows of `contact_cone(options)`: edges + 6 + 8 for corners + number of finite sides of
/// the normal force.
int contact_cone_rows(const ContactCone::Options& options);

// Usage inside a term, for w of any scalar: the formula returns `Vec<S, 14>(rows * w)`, where
// `rows` is `cone.fixed<14>()`. Its upper bounds are `cone.fixed_bounds<14>()`. The exact zeros of
// the rows stay out of the sparsity pattern.

/// The rows A w of a contact cone, for the wrench w that starts at entry `first` of z. The function
/// is affine with any number of rows. It is not written as a formula, which would be compiled for
/// each number of rows and each problem.
Function cone_rows(const ContactCone& cone, const Arguments& sizes, int first);

/// Keeps the inputs first .. first + 5, a wrench in the axes of its sole, in the cone during the
/// window. Friction, torsion and centre of pressure become one term, the normal force becomes
/// bounds on the input.
template <int nx, int nu, int np>
void keep_in_cone(Phase<nx, nu, np>& phase, const std::string& name, ContactCone::Options options,
                  int first, const Window& window = {}) {
  options.normal_force_rows = false;
  const ContactCone cone = contact_cone(options);
  const Arguments sizes = phase.definition().sizes;
  phase.bound_input(first + 2, cone.normal_force, window)
      .keep(name, cone_rows(cone, sizes, sizes.u(first)), at_most(0.0), window);
}

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using ContactCone [[deprecated("use robots::ContactCone; removed in 0.4")]] = robots::ContactCone;
/// Deprecated name.
using FrictionPyramid [[deprecated("use robots::ContactCone::Pyramid; removed in 0.4")]] =
    robots::ContactCone::Pyramid;
/// Deprecated name.
using ContactConeOptions [[deprecated("use robots::ContactCone::Options; removed in 0.4")]] =
    robots::ContactCone::Options;
using robots::contact_cone;       ///< deprecated name
using robots::contact_cone_rows;  ///< deprecated name
using robots::keep_in_cone;       ///< deprecated name
}  // namespace saltus
