// A state that is 1 at both ends and has a cost everywhere else: two thin boundary layers with
// nothing between them.
//
//   min int x^2 + e^2 u^2   x' = u   x(0) = x(1) = 1,  e = 1/100
//
// x = cosh((t - 1/2) / e) / cosh(1 / (2 e)), J = 2 e tanh(1 / (2 e)). The layers have thickness
// e. A graded mesh of 60 intervals, 40 times shorter at the ends than in the middle, has ten in
// each layer.
// Guess: the constant start, no input.
// Source: the standard example of singular perturbation; closed form.
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double thickness = 0.01;

struct Slope {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

OptimalControlProblem problem() {
  Phase<1, 1> phase{"layers", Slope{}, exactly(1.0)};
  phase
      .minimise("cost",
                [](const auto&, const auto& x, const auto& u) {
                  return x[0] * x[0] + thickness * thickness * u[0] * u[0];
                })
      .reach(
          "end", [](const auto&, const auto& x) { return x[0]; }, exactly(1.0))
      .inputs(InputParametrisation::piecewise_linear_continuous)
      .nominal(Vec<double, 1>{1.0}, Vec<double, 1>{1.0 / thickness});
  OptimalControlProblem ocp("boundary layers");
  return ocp.start_at({1}).then(phase);
}

}  // namespace

ReferenceCase boundary_layers() {
  return {.id = "E07",
          .name = "boundary_layers",
          .summary = "Two thin boundary layers with a flat solution between them.",
          .states = {"x"},
          .inputs = {"u"},
          .exercises = "a mesh graded to both ends of a phase",
          .source = "singular perturbation; closed form",
          .problem = problem,
          .options = {.meshes = {mesh_graded_to_both_ends(60, 40.0)}, .integrator = runge_kutta8()},
          .optimum = 2.0 * thickness * std::tanh(0.5 / thickness),
          .digits = 15,
          // Linear pieces of a tenth of the layer have a relative cost error of 1e-5, 60 equal
          // intervals 1e-3.
          .tolerance = 1e-6};
}

}  // namespace saltus::library
