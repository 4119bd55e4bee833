#include "saltus/robots/whole_body/whole_body_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/cholesky.hpp"
#include "saltus/robots/whole_body/clearance.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"

namespace saltus::robots {
namespace {

constexpr int left = 0, right = 1;
// Order of the groups of rows.
constexpr int cone_group = 0, torque_group = 2, stance_group = 3, limit_group = 4,
              clearance_group = 5;

// Largest number of pairs of limbs that have a row, and the distance below which they have one, m.
constexpr int nearest_pairs = 6;
constexpr double near = 0.15;

// Torques above this share of the motor limit in the previous step have rows from the start.
constexpr double near_effort = 0.7;
// Accuracy of the rows, Nm. A torque without a row receives one if it exceeds its limit by more.
constexpr double effort_tolerance = 1e-6;

// A centre of pressure within this distance of the end of an edge, m, is moving to a corner.
constexpr double corner = 0.01;

qp::StageQp capacity(int joints, const ContactCone cones[2], bool clearance) {
  const int all = joints + 12;
  qp::StageCapacity stage{0, all, {}};
  for (const int foot : {left, right}) stage.groups.push_back({cones[foot].rows(), 6, false});
  stage.groups.push_back({joints, all, false});
  stage.groups.push_back({12, all, true});
  stage.groups.push_back({joints, joints, true});
  if (clearance) stage.groups.push_back({nearest_pairs, joints, true});
  return qp::StageQp({stage});
}

int row_of_most_force(const ContactCone& cone) {
  const auto found = std::find(cone.names.begin(), cone.names.end(), "normal force max");
  return found == cone.names.end() ? -1 : static_cast<int>(found - cone.names.begin());
}

class InverseDynamicsController final : public WholeBodyController {
 public:
  InverseDynamicsController(const FloatingRobot& robot, const ContactCone::Options& left_contact,
                            const ContactCone::Options& right_contact,
                            const WholeBodyController::Weights& weights_in,
                            const WholeBodyController::Gains& gains_in)
      : n(robot.joints()),
        weights(weights_in),
        gains(gains_in),
        cones{contact_cone(left_contact), contact_cone(right_contact)},
        rectangle{left_contact.foot, right_contact.foot},
        pressure_rows{left_contact.edges + 2, right_contact.edges + 2},
        most_force_row_{row_of_most_force(cones[left]), row_of_most_force(cones[right])},
        qp(capacity(n, cones, gains_in.clearance)),
        point(qp),
        effort(n),
        smallest(n),
        largest(n),
        lower(n),
        upper(n),
        fastest(n) {
    for (int i = 0; i < n; ++i) {
      effort[i] = robot.bodies[i + 1].effort;
      drives.push_back(robot.bodies[i + 1].drive);
      fastest[i] = robot.bodies[i + 1].velocity;
      lower[i] = robot.bodies[i + 1].position.lower + gains.limit_margin;
      upper[i] = robot.bodies[i + 1].position.upper - gains.limit_margin;
      if (!(lower[i] <= upper[i]))
        throw DefinitionError(fmt::format(
            "inverse dynamics: the range of joint {} is less than twice limit_margin, {} rad",
            robot.bodies[i + 1].joint, gains.limit_margin));
    }
    for (const int foot : {left, right}) {
      leg[foot].resize(n);
      for (int b = (foot == left ? robot.left_sole : robot.right_sole).body; b > 0;
           b = robot.bodies[b].parent)
        leg[foot][b - 1] = true;
    }
    if (gains.clearance) {
      clearance.emplace(robot, nearest_pairs);
      row.resize(n);
    }
    qp::RiccatiOptions options;
    options.tolerance = 1e-6;
    options.max_iterations = 40;
    solver = qp::make_riccati_solver(qp, options);
    const int all = n + 12;
    base.resize(6, all);
    base_0.resize(6);
    torque.resize(n, all);
    torque_0.resize(n);
    bounded.resize(n);
    exerted.resize(n);
    task.resize(6, all);
    command.torques = VectorXd::Zero(n);
    command.joint_acceleration = VectorXd::Zero(n);
  }

  void stand(const WholeBodyState& state) override {
    if (clearance) clearance->stand(state, gains.clearance_margin);
  }
  const WholeBodyController::Command& control(
      const DynamicsModel& model, const WholeBodyState& state,
      const WholeBodyController::Tasks& tasks) noexcept override;

 private:
  int n;
  WholeBodyController::Weights weights;
  WholeBodyController::Gains gains;
  ContactCone cones[2];
  FootRectangle rectangle[2];
  // first of four rows in the cone: centre of pressure x min, max, y min, max
  int pressure_rows[2];
  int most_force_row_[2];  // of the cone; -1: none
  qp::StageQp qp;
  qp::StagePoint point;
  VectorXd effort, smallest, largest;  // largest torque at rest, and range of torques at this speed
  std::vector<JointDrive> drives;
  VectorXd lower, upper, fastest;
  std::vector<bool> leg[2];  // true if a joint lies between base and sole
  std::optional<Clearance> clearance;
  VectorXd row;
  std::unique_ptr<qp::StageQpSolver> solver;

  MatrixXd base;  // base acceleration = base z + base_0
  VectorXd base_0;
  MatrixXd torque;  // torques = torque z + torque_0
  VectorXd torque_0;
  MatrixXd task;
  WholeBodyController::Command command;
  std::vector<bool> bounded;   // true if the torque of a joint has a row
  VectorXd exerted;            // torques at the solution of the program
  int standing[2] = {-1, -1};  // first column of the wrench of each foot, -1: in the air
  int size = 0;

  void build(const DynamicsModel& model, const WholeBodyState& state,
             const WholeBodyController::Tasks& tasks);
  void add_cost(int rows, const Vec<double, 6>& wanted, double weight);
  void add_foot_acceleration(const DynamicsModel::SoleMotion& sole);
  void set_torque_ranges(const WholeBodyState& state);
  void bound_torque(int joint);
  bool bound_torques_beyond();
  void set_limits(const WholeBodyState& state);
  void keep_on_support(qp::RowGroup& cone, int foot, const WholeBodyController::Tasks& tasks) const;
  void keep_off_tipped_corners(qp::RowGroup& cone, int foot, const Mat<double, 3, 3>& sole) const;
  void set_clearance(const WholeBodyState& state);
  double approach_speed(double distance) const;
};

// 1/2 weight |task z - wanted|^2 for the first rows of `task`.
void InverseDynamicsController::add_cost(int rows, const Vec<double, 6>& wanted, double weight) {
  qp::Stage& stage = qp.stages[0];
  const auto J = task.topLeftCorner(rows, size);
  stage.R.topLeftCorner(size, size).noalias() += weight * J.transpose() * J;
  stage.r.head(size).noalias() -= weight * J.transpose() * wanted.head(rows);
}

// d twist / dt = task z + J_b base_0 + drift. Callers subtract the terms that do not depend on z.
void InverseDynamicsController::add_foot_acceleration(const DynamicsModel::SoleMotion& sole) {
  task.leftCols(size).noalias() = sole.jacobian.leftCols(6) * base.leftCols(size);
  task.leftCols(n) += sole.jacobian.rightCols(n);
}

void InverseDynamicsController::build(const DynamicsModel& model, const WholeBodyState& state,
                                      const WholeBodyController::Tasks& tasks) {
  const MatrixXd& M = model.mass_matrix();
  const VectorXd& h = model.bias();
  const DynamicsModel::SoleMotion* soles[2] = {&model.sole(Side::left), &model.sole(Side::right)};
  size = n;
  for (const int foot : {left, right}) {
    standing[foot] = -1;
    if (!(foot == left ? tasks.left_stands : tasks.right_stands)) continue;
    standing[foot] = size;
    size += 6;
  }
  qp::Stage& stage = qp.stages[0];
  stage.nx = 0;
  stage.nu = size;

  // The base's equations: M_bb a + M_bj d2q + h_b = J_b' w.
  Cholesky<6> factor;
  factor.compute(M.topLeftCorner<6, 6>());
  base.leftCols(n) = -M.topRightCorner(6, n);
  torque.leftCols(n) = M.bottomRightCorner(n, n);
  for (const int foot : {left, right}) {
    if (standing[foot] < 0) continue;
    const Mat<double, 6, 6> world = wrench_to_world(*soles[foot]);
    base.middleCols(standing[foot], 6).noalias() =
        soles[foot]->jacobian.leftCols<6>().transpose() * world;
    const Mat<double, 6, 6> reaction = -world;  // a minus in the product would allocate
    torque.middleCols(standing[foot], 6).noalias() =
        soles[foot]->jacobian.rightCols(n).transpose() * reaction;
  }
  factor.solve_in_place(base.leftCols(size));
  Vec<double, 6> rest = -h.head<6>();
  factor.solve_in_place(rest);
  base_0 = rest;
  torque.leftCols(size).noalias() += M.bottomLeftCorner(n, 6) * base.leftCols(size);
  torque_0.noalias() = h.tail(n) + M.bottomLeftCorner(n, 6) * base_0;

  // Costs.
  stage.R.topLeftCorner(size, size).setZero();
  stage.r.head(size).setZero();
  for (int i = 0; i < n; ++i) {
    const double wanted =
        gains.posture * (tasks.posture[i] - state.q[i]) - gains.posture_damping * state.dq[i];
    stage.R(i, i) += weights.posture;
    stage.r[i] -= weights.posture * wanted;
  }
  task.leftCols(size).setZero();
  for (const int foot : {left, right}) {
    if (standing[foot] < 0) continue;
    const Mat<double, 3, 3> R = soles[foot]->pose.linear();
    task.block<3, 3>(0, standing[foot]) = R;
  }
  Vec<double, 6> wanted = Vec<double, 6>::Zero();
  wanted.head<3>() = tasks.force + Vec<double, 3>(0.0, 0.0, model.mass() * standard_gravity);
  add_cost(3, wanted, weights.linear_momentum);
  task.leftCols(size).setZero();
  for (const int foot : {left, right}) {
    if (standing[foot] < 0) continue;
    const Mat<double, 3, 3> R = soles[foot]->pose.linear();
    task.block<3, 3>(0, standing[foot]) =
        skew<double>(soles[foot]->pose.translation() - model.com()) * R;
    task.block<3, 3>(0, standing[foot] + 3) = R;
  }
  wanted.head<3>() = tasks.torque;
  add_cost(3, wanted, weights.angular_momentum);
  for (const int foot : {left, right}) {
    if (standing[foot] >= 0) {
      for (int i = 0; i < 6; ++i) {
        stage.R(standing[foot] + i, standing[foot] + i) += weights.wrench;
        stage.r[standing[foot] + i] -= weights.wrench * tasks.wrenches[6 * foot + i];
      }
    } else {
      add_foot_acceleration(*soles[foot]);
      wanted = tasks.swing_acceleration - soles[foot]->drift -
               soles[foot]->jacobian.leftCols<6>() * base_0;
      add_cost(6, wanted, weights.swing_foot);
    }
  }

  // Rows.
  set_torque_ranges(state);
  qp::RowGroup& torques = stage.groups[torque_group];
  torques.rows = 0;
  torques.columns.resize(size);
  for (int i = 0; i < size; ++i) torques.columns[i] = i;
  std::fill(bounded.begin(), bounded.end(), false);
  for (int i = 0; i < n; ++i)
    if (command.torques[i] > near_effort * largest[i] ||
        command.torques[i] < near_effort * smallest[i])
      bound_torque(i);

  qp::RowGroup& stance = stage.groups[stance_group];
  stance.soft = true;
  stance.rows = 0;
  stance.columns = torques.columns;
  for (const int foot : {left, right}) {
    qp::RowGroup& cone = stage.groups[cone_group + foot];
    cone.rows = 0;
    if (standing[foot] < 0) continue;
    keep_in_cone(cone, cones[foot], standing[foot]);
    keep_on_support(cone, foot, tasks);
    keep_off_tipped_corners(cone, foot, soles[foot]->pose.linear());

    add_foot_acceleration(*soles[foot]);
    stance.M.block(stance.rows, 0, 6, size) = task.leftCols(size);
    wanted = (foot == left ? tasks.left_hold : tasks.right_hold) -
             gains.stance_damping * soles[foot]->twist - soles[foot]->drift -
             soles[foot]->jacobian.leftCols<6>() * base_0;
    stance.lower.segment<6>(stance.rows) = wanted;
    stance.upper.segment<6>(stance.rows) = wanted;
    stance.rows += 6;
  }
  stance.l1.setConstant(weights.stance_weight);
  stance.l2.setZero();

  set_limits(state);
  if (clearance) set_clearance(state);
}

// The motor exerts the torque of the joint and its friction.
void InverseDynamicsController::set_torque_ranges(const WholeBodyState& state) {
  for (int i = 0; i < n; ++i) {
    const JointDrive& drive = drives[static_cast<std::size_t>(i)];
    const Bounds range = drive.torque_range(effort[i], state.dq[i]);
    const double friction = drive.friction(state.dq[i]);
    // Zero stays feasible if the friction exceeds the motor's torque.
    smallest[i] = std::min(0.0, range.lower - friction);
    largest[i] = std::max(0.0, range.upper - friction);
  }
}

// Most motors are far from their limits, and a row of torques is dense. So only torques that are
// near or beyond a limit have a row.
void InverseDynamicsController::bound_torque(int joint) {
  qp::RowGroup& torques = qp.stages[0].groups[torque_group];
  const int i = torques.rows++;
  torques.M.row(i).head(size) = torque.row(joint).head(size);
  torques.lower[i] = smallest[joint] - torque_0[joint];
  torques.upper[i] = largest[joint] - torque_0[joint];
  bounded[joint] = true;
}

// Adds rows for torques that have none and exceed their limits. Returns true if there were any.
bool InverseDynamicsController::bound_torques_beyond() {
  bool any = false;
  for (int i = 0; i < n; ++i) {
    if (bounded[i] || (exerted[i] <= largest[i] + effort_tolerance &&
                       exerted[i] >= smallest[i] - effort_tolerance))
      continue;
    bound_torque(i);
    any = true;
  }
  return any;
}

// The cone has its rows of the normal force last.
void InverseDynamicsController::keep_on_support(qp::RowGroup& cone, int foot,
                                                const WholeBodyController::Tasks& tasks) const {
  const std::optional<FootRectangle>& area =
      foot == left ? tasks.left_support : tasks.right_support;
  if (area) {
    const double ends[] = {area->x.lower, -area->x.upper, area->y.lower, -area->y.upper};
    for (int i = 0; i < 4; ++i) cone.M(pressure_rows[foot] + i, 2) = ends[i];
  }
  const double most = foot == left ? tasks.left_most_load : tasks.right_most_load;
  if (most_force_row_[foot] >= 0 && most < cone.upper[most_force_row_[foot]])
    cone.upper[most_force_row_[foot]] = most;
}

// The ground supports a tipped sole only where the sole touches it, independent of the requested
// wrench. A wrench away from the loaded edge turns the sole back. A sole may stay on the middle of
// an edge. On a corner it would rotate further as soon as the load moves.
void InverseDynamicsController::keep_off_tipped_corners(qp::RowGroup& cone, int foot,
                                                        const Mat<double, 3, 3>& sole) const {
  if (gains.tipped_reserve == 0.0) return;
  const Bounds sides[2] = {rectangle[foot].x, rectangle[foot].y};
  const auto last = command.wrenches.segment<6>(6 * foot);
  double rise[2], lifted[2], on_end[2];
  for (const int axis : {0, 1}) {
    const double width = sides[axis].upper - sides[axis].lower;
    rise[axis] = sole(2, axis) * width;
    lifted[axis] = std::max(0.0, std::abs(rise[axis]) - gains.tipped_threshold);
    // Degree to which the sole stands on an end of the edge along this axis.
    on_end[axis] = std::min(1.0, lifted[axis] / gains.tipped_threshold);
    if (last[2] <= 0.0) continue;
    const double pressure = (axis == 0 ? -last[4] : last[3]) / last[2];
    const double from_end =
        std::min(pressure - sides[axis].lower, sides[axis].upper - pressure) / corner;
    on_end[axis] = std::clamp(1.0 - from_end, on_end[axis], 1.0);
  }
  for (const int axis : {0, 1}) {
    const double most =
        std::min(gains.most_tipped_reserve, 0.25 * (sides[axis].upper - sides[axis].lower));
    const double reserve = std::min(gains.tipped_reserve * lifted[axis], most);
    const double rim = rise[axis] > 0.0 ? sides[axis].lower : -sides[axis].upper;
    double& end = cone.M(pressure_rows[foot] + 2 * axis + (rise[axis] > 0.0 ? 0 : 1), 2);
    end = std::max(end, rim + on_end[1 - axis] * reserve);
  }
}

// Largest speed of a joint towards its limit, rad/s: low enough to brake in time, and linear close
// to the limit.
double InverseDynamicsController::approach_speed(double distance) const {
  const double T = gains.limit_horizon, a = gains.braking;
  if (distance < a * T * T) return distance / T;
  return std::sqrt(2.0 * a * distance - a * a * T * T);  // continuous in value and slope
}

// A joint may approach its limit at (limit - q) / T and returns to that speed within T / 4. This is
// critically damped, so the joint does not overshoot.
void InverseDynamicsController::set_limits(const WholeBodyState& state) {
  qp::RowGroup& limits = qp.stages[0].groups[limit_group];
  limits.soft = true;
  limits.rows = n;
  limits.columns.resize(n);
  for (int i = 0; i < n; ++i) limits.columns[i] = i;
  limits.M.topLeftCorner(n, n).setIdentity();
  const double T = gains.limit_horizon;
  limits.lower = (4.0 / (T * T)) * (lower - state.q - T * state.dq);
  limits.upper = (4.0 / (T * T)) * (upper - state.q - T * state.dq);
  if (gains.speed_limits)
    for (int i = 0; i < n; ++i) {
      bool swings = false;
      for (const int foot : {left, right}) swings |= standing[foot] < 0 && leg[foot][i];
      const double most =
          (1.0 - (swings ? gains.swing_speed_margin : gains.speed_margin)) * fastest[i];
      const double back = approach_speed(state.q[i] - lower[i]);
      const double ahead = approach_speed(upper[i] - state.q[i]);
      // The measured velocity is delayed. Extrapolate it with the acceleration of the last command.
      const double speed = state.dq[i] + gains.velocity_age * command.joint_acceleration[i];
      limits.lower[i] =
          std::max((4.0 / T) * (-back - speed), gains.speed_approach * (-most - speed));
      limits.upper[i] =
          std::min((4.0 / T) * (ahead - speed), gains.speed_approach * (most - speed));
      // If a joint is far above its largest speed, its lower bound may exceed its upper bound.
      limits.upper[i] = std::max(limits.lower[i], limits.upper[i]);
    }
  limits.l1.setConstant(weights.limit_weight);
  limits.l2.setZero();
}

// Limbs approach each other like joints approach their limits.
void InverseDynamicsController::set_clearance(const WholeBodyState& state) {
  const double T = gains.clearance_horizon;
  clearance->update(state, near, T);
  qp::RowGroup& rows = qp.stages[0].groups[clearance_group];
  rows.soft = true;
  rows.rows = clearance->count();
  rows.columns.resize(n);
  for (int i = 0; i < n; ++i) rows.columns[i] = i;
  for (int i = 0; i < rows.rows; ++i) {
    const Approach& a = clearance->approach(i);
    clearance->jacobian(i, row);
    rows.M.row(i).head(n) = row.transpose();
    rows.lower[i] =
        (4.0 / (T * T)) * (std::min(gains.clearance_margin, a.keep) - a.distance - T * a.speed) -
        a.drift;
    rows.upper[i] = infinity;
  }
  rows.l1.setConstant(weights.clearance_weight);
  rows.l2.setZero();
}

const WholeBodyController::Command& InverseDynamicsController::control(
    const DynamicsModel& model, const WholeBodyState& state,
    const WholeBodyController::Tasks& tasks) noexcept {
  build(model, state, tasks);
  const auto z = point.stages[0].u.head(size);
  command.iterations = 0;
  command.solve_seconds = 0.0;
  do {
    const double begin = thread_microseconds();
    const qp::QpResult r = solver->solve(qp, point, false);
    command.status = r.status;
    command.iterations += r.iterations;
    command.solve_seconds += 1e-6 * (thread_microseconds() - begin);
    if (r.status != qp::QpStatus::optimal && !(r.residual < 1e-2)) return command;
    exerted.noalias() = torque.leftCols(size) * z;
    exerted += torque_0;
  } while (bound_torques_beyond());
  command.joint_acceleration = z.head(n);
  command.torques = exerted.cwiseMax(smallest).cwiseMin(largest);
  command.wrenches.setZero();
  for (const int foot : {left, right})
    if (standing[foot] >= 0) command.wrenches.segment<6>(6 * foot) = z.segment<6>(standing[foot]);
  const auto excess = [&](int group) {
    const qp::RowGroup& g = qp.stages[0].groups[group];
    double most = 0.0;
    for (int i = 0; i < g.rows; ++i) {
      double value = 0.0;
      for (std::size_t c = 0; c < g.columns.size(); ++c)
        value += g.M(i, static_cast<int>(c)) * z[g.columns[c]];
      most = std::max({most, g.lower[i] - value, value - g.upper[i]});
    }
    return most;
  };
  command.stance_slip = excess(stance_group);
  command.limit_excess = excess(limit_group);
  return command;
}

}  // namespace

std::unique_ptr<WholeBodyController> make_inverse_dynamics_controller(
    const FloatingRobot& robot, const ContactCone::Options& left_contact,
    const ContactCone::Options& right_contact, const WholeBodyController::Weights& weights,
    const WholeBodyController::Gains& gains) {
  return std::make_unique<InverseDynamicsController>(robot, left_contact, right_contact, weights,
                                                     gains);
}

}  // namespace saltus::robots
