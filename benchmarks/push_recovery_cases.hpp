// Numeric instances of the push recovery problem with their solutions.
#pragma once

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "problems/push_recovery/problem.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::push_recovery {

struct QpCase {
  Model model;
  Weights weights;
  Tick<double> data;
  VectorXd start;
  double impact_time = infinity;
  double optimum = 0.0;
  MatrixXd gamma;  // node x state
  MatrixXd f;      // interval x input
};

inline VectorXd numbers(const nlohmann::json& list) {
  VectorXd v(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) v[i] = list[i].get<double>();
  return v;
}

inline MatrixXd table(const nlohmann::json& list) {
  MatrixXd m(list.size(), list[0].size());
  for (std::size_t i = 0; i < list.size(); ++i) m.row(i) = numbers(list[i]).transpose();
  return m;
}

/// Reads a case of benchmarks/data/step_recovery_qp_cases.json: circumscribed four-edge
/// friction pyramid, costs summed at the nodes, capture point rows hard from the impact on.
inline QpCase read_case(const std::string& name) {
  std::ifstream file(SALTUS_BENCHMARK_DATA "/step_recovery_qp_cases.json");
  const nlohmann::json json = nlohmann::json::parse(file).at(name);
  const nlohmann::json& p = json.at("params");
  QpCase c;
  c.model.mass = p.at("m");
  robots::ContactCone::Options contact;
  contact.friction = p.at("mu");
  contact.edges = 4;
  contact.pyramid = robots::ContactCone::Pyramid::circumscribed;
  contact.foot.x = between(p.at("foot_x")[0], p.at("foot_x")[1]);
  contact.foot.y = between(p.at("foot_y")[0], p.at("foot_y")[1]);
  contact.torsional_friction = p.at("mu_z");
  contact.normal_force = at_least(p.at("f_z_min"));
  c.model.left_contact = c.model.right_contact = contact;
  c.model.step = p.at("dt");
  c.model.intervals = p.at("N");

  c.weights.gamma = numbers(p.at("K_gamma"));
  c.weights.gamma_impact = numbers(p.at("K_gamma_imp"));
  c.weights.wrench = numbers(p.at("K_f")).head<6>();
  c.weights.capture_point = numbers(p.at("K_icp"));
  c.weights.capture_point_penalty = 0.0;
  c.weights.wrench_change = 0.0;

  c.start.resize(9);
  c.start << numbers(p.at("x_com0")), numbers(p.at("v_com0")), numbers(p.at("H0"));
  c.data.com = c.start.head<3>();
  c.data.force = (numbers(p.at("f_l0")) + numbers(p.at("f_r0"))).head<3>();
  c.data.omega = std::sqrt(p.at("g").get<double>() / c.start[2]);
  c.data.left_foot = numbers(p.at("x_l")).head<3>();
  c.data.right_foot = numbers(p.at("x_r")).head<3>();
  c.data.gamma_desired = numbers(p.at("gamma_d"));
  c.data.capture_point_desired = numbers(p.at("icp_d")).head<2>();
  Eigen::Matrix<double, 4, 2> corners;
  const auto x = p.at("hull_x"), y = p.at("hull_y");
  corners << x[0], y[0], x[1], y[0], x[1], y[1], x[0], y[1];
  c.data.set_hull(robots::SupportPolygon::hull(corners).half_planes(hull_rows));

  const int k = p.at("k_impact");
  c.impact_time = k * c.model.step;
  c.optimum = json.at("J_opt");
  c.gamma = table(json.at("gamma"));
  c.f = table(json.at("f"));
  return c;
}

inline MultipleShooting transcribe(const QpCase& c) {
  OptimalControlProblem ocp =
      problem(c.model, c.weights, c.data, walking::one_foot_then_two(c.impact_time));
  ocp.start_at(c.start);
  return MultipleShooting(
      std::move(ocp), {.intervals_per_phase = c.model.intervals, .integrator = zero_order_hold()});
}

}  // namespace saltus::push_recovery
