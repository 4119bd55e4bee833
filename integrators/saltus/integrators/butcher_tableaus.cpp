// Coefficients of the explicit tableaus. tests/integrators measures their order.
#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

ButcherTableau classical_runge_kutta() {
  ButcherTableau tableau;
  tableau.name = "Runge-Kutta 4";
  tableau.order = 4;
  tableau.a = MatrixXd::Zero(4, 4);
  tableau.a(1, 0) = tableau.a(2, 1) = 0.5;
  tableau.a(3, 2) = 1.0;
  tableau.b = (VectorXd(4) << 1.0, 2.0, 2.0, 1.0).finished() / 6.0;
  tableau.c = tableau.a.rowwise().sum();
  return tableau;
}

// G. J. Cooper and J. H. Verner, Some explicit Runge-Kutta methods of high order, SIAM J. Numer.
// Anal. 9 (1972) 389-405. Nodes 0, 1/2, 1/2, (7+r)/14, (7+r)/14, 1/2, (7-r)/14, (7-r)/14, 1/2,
// (7+r)/14, 1 with r = sqrt(21); the weights are those of Lobatto's quadrature with five points.
ButcherTableau cooper_verner() {
  const double r = std::sqrt(21.0);
  ButcherTableau tableau;
  tableau.name = "Runge-Kutta 8";
  tableau.order = 8;
  MatrixXd& a = tableau.a;
  a = MatrixXd::Zero(11, 11);
  a(1, 0) = 1.0 / 2;
  a(2, 0) = 1.0 / 4;
  a(2, 1) = 1.0 / 4;
  a(3, 0) = 1.0 / 7;
  a(3, 1) = (-7 - 3 * r) / 98;
  a(3, 2) = (21 + 5 * r) / 49;
  a(4, 0) = (11 + r) / 84;
  a(4, 2) = (18 + 4 * r) / 63;
  a(4, 3) = (21 - r) / 252;
  a(5, 0) = (5 + r) / 48;
  a(5, 2) = (9 + r) / 36;
  a(5, 3) = (-231 + 14 * r) / 360;
  a(5, 4) = (63 - 7 * r) / 80;
  a(6, 0) = (10 - r) / 42;
  a(6, 2) = (-432 + 92 * r) / 315;
  a(6, 3) = (633 - 145 * r) / 90;
  a(6, 4) = (-504 + 115 * r) / 70;
  a(6, 5) = (63 - 13 * r) / 35;
  a(7, 0) = 1.0 / 14;
  a(7, 4) = (14 - 3 * r) / 126;
  a(7, 5) = (13 - 3 * r) / 63;
  a(7, 6) = 1.0 / 9;
  a(8, 0) = 1.0 / 32;
  a(8, 4) = (91 - 21 * r) / 576;
  a(8, 5) = 11.0 / 72;
  a(8, 6) = (-385 - 75 * r) / 1152;
  a(8, 7) = (63 + 13 * r) / 128;
  a(9, 0) = 1.0 / 14;
  a(9, 4) = 1.0 / 9;
  a(9, 5) = (-733 - 147 * r) / 2205;
  a(9, 6) = (515 + 111 * r) / 504;
  a(9, 7) = (-51 - 11 * r) / 56;
  a(9, 8) = (132 + 28 * r) / 245;
  a(10, 4) = (-42 + 7 * r) / 18;
  a(10, 5) = (-18 + 28 * r) / 45;
  a(10, 6) = (-273 - 53 * r) / 72;
  a(10, 7) = (301 + 53 * r) / 72;
  a(10, 8) = (28 - 28 * r) / 45;
  a(10, 9) = (49 - 7 * r) / 18;
  tableau.b = VectorXd::Zero(11);
  tableau.b[0] = tableau.b[10] = 1.0 / 20;
  tableau.b[7] = tableau.b[9] = 49.0 / 180;
  tableau.b[8] = 16.0 / 45;
  tableau.c = a.rowwise().sum();
  return tableau;
}

}  // namespace saltus
