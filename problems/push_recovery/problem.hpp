// Sizes, weights and options of the push recovery problem; problem.cpp contains its mathematics.
#pragma once

#include "problems/push_recovery/tick_data.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus::push_recovery {

using Vector9 = Vec<double, 9>;
using Vector6 = Vec<double, 6>;

/// Weights of the five terms of the cost Gamma ("Cost function definition" of the paper).
struct Weights {
  Vector9 gamma{0, 0, 1e5, 1000, 1000, 1000, 400, 400, 400};    // K_gamma
  Vector9 gamma_impact{2500, 4000, 0, 5000, 5000, 0, 0, 0, 0};  // K_gamma^imp
  Vector6 wrench{0.002, 0.002, 1e-4, 0.02, 0.02, 0.02};         // K_f, each foot
  Vec<double, 2> capture_point{1e5, 1e5};                       // K_icp
  Vec<double, 2> capture_point_standing{3e4, 3e5};  // the same, as long as no step is planned
  double wrench_change = 1e-4;         // on first differences of every component; the paper has 0
  double capture_point_penalty = 1e4;  // penalty on leaving the hull, per m and s; 0: not allowed
};

struct Model {
  double mass = 33.06;  // kg
  robots::ContactCone::Options left_contact = {}, right_contact = {};
  double step = 0.01;                    // dt, s
  int intervals = 15;                    // N
  CostRule cost_rule = CostRule::nodes;  // the paper sums costs over the samples
  bool estimates_support = false;        ///< keep the centres of pressure in the areas of the data
  bool follows_motion = false;  ///< follow the motion of the data instead of coming to rest at the
                                ///< target
};

/// The problem of one tick. The contacts are those of saltus/robots/walking/contacts.hpp, in
/// absolute time. Data "tick": Tick.
OptimalControlProblem problem(const Model& model, const Weights& weights, const Tick<double>& data,
                              const Schedule& contacts);

}  // namespace saltus::push_recovery
