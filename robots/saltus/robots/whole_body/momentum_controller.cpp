#include "saltus/robots/whole_body/whole_body_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/cholesky.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"

namespace saltus::robots {
namespace {

constexpr int feet = 2;

void check(const WholeBodyController::MomentumOptions& o) {
  const auto refuse = [](const char* name, double value, const char* rule) {
    throw DefinitionError(
        fmt::format("momentum controller: {} must be {}, not {}", name, rule, value));
  };
  const auto not_negative = [&](const char* name, double value) {
    if (!(value >= 0.0) || !std::isfinite(value)) refuse(name, value, "finite and not negative");
  };
  const auto positive = [&](const char* name, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) refuse(name, value, "finite and positive");
  };
  not_negative("linear_momentum", o.linear_momentum);
  not_negative("angular_momentum", o.angular_momentum);
  not_negative("torque", o.torque);
  positive("wrench", o.wrench);
  not_negative("posture", o.posture);
  not_negative("posture_damping", o.posture_damping);
  not_negative("stance_damping", o.stance_damping);
  positive("stance_regularisation", o.stance_regularisation);
  positive("swing_regularisation", o.swing_regularisation);
  positive("limit_horizon", o.limit_horizon);
}

qp::StageQp capacity(const ContactCone cones[feet]) {
  qp::StageCapacity stage{0, 6 * feet, {}};
  for (int i = 0; i < feet; ++i) stage.groups.push_back({cones[i].rows(), 6, false});
  return qp::StageQp({stage});
}

class MomentumController final : public WholeBodyController {
 public:
  MomentumController(const FloatingRobot& robot, const ContactCone::Options& left,
                     const ContactCone::Options& right,
                     const WholeBodyController::MomentumOptions& options)
      : n_(robot.joints()),
        options_(options),
        cones_{contact_cone(left), contact_cone(right)},
        qp_(capacity(cones_)),
        point_(qp_),
        effort_(n_),
        lower_(n_),
        upper_(n_),
        base_(6, n_),
        mass_(n_, n_),
        mass_factor_(n_),
        bias_(n_),
        posture_(n_),
        jacobian_(12, n_),
        transfer_(n_, 12),
        gram_(12, 12),
        gram_factor_(12),
        effort_of_missing_(12),
        torque_(n_, 12),
        torque_0_(n_),
        rest_(n_) {
    check(options);
    for (int i = 0; i < n_; ++i) {
      effort_[i] = robot.bodies[i + 1].effort;
      lower_[i] = robot.bodies[i + 1].position.lower;
      upper_[i] = robot.bodies[i + 1].position.upper;
    }
    qp::RiccatiOptions solver;
    solver.tolerance = 1e-6;  // N and Nm; wrenches are of order 100
    solver.max_iterations = 40;
    solver_ = qp::make_riccati_solver(qp_, solver);
    pull_.setZero();
    momentum_.setZero();
    command_.torques = VectorXd::Zero(n_);
    command_.joint_acceleration = VectorXd::Zero(n_);
  }

  const WholeBodyController::Command& control(
      const DynamicsModel& model, const WholeBodyState& state,
      const WholeBodyController::Tasks& tasks) noexcept override;

 private:
  void eliminate_base(const DynamicsModel& model);
  void set_feet(const DynamicsModel& model, const WholeBodyState& state,
                const WholeBodyController::Tasks& tasks);
  bool find_wrenches(const DynamicsModel& model, const WholeBodyController::Tasks& tasks);
  void finish(const WholeBodyState& state);
  double limit_excess(const WholeBodyState& state) const;

  int n_;
  WholeBodyController::MomentumOptions options_;
  ContactCone cones_[feet];
  qp::StageQp qp_;
  qp::StagePoint point_;
  std::unique_ptr<qp::StageQpSolver> solver_;
  VectorXd effort_, lower_, upper_;

  // Equations with the base eliminated: mass d2q + bias = tau + sum jacobian_i' w_i.
  Cholesky<6> base_factor_;   // factor of M_bb
  MatrixXd base_;             // M_bb^-1 M_bj
  Vec<double, 6> base_bias_;  // M_bb^-1 h_b
  MatrixXd mass_;
  Cholesky<Eigen::Dynamic> mass_factor_;
  VectorXd bias_;

  VectorXd posture_;   // requested joint accelerations
  MatrixXd jacobian_;  // Jacobian of both feet, including the motion of the base
  MatrixXd transfer_;  // Lambda'
  MatrixXd gram_;      // Lambda Lambda', regularised
  Cholesky<Eigen::Dynamic> gram_factor_;
  VectorXd effort_of_missing_;  // gram_^-1 missing_
  Mat<double, 12, 12> pull_;    // acceleration of the feet through the base, per sole wrench
  // foot acceleration that remains after posture and free fall of the base
  Vec<double, 12> missing_;
  Mat<double, 6, 12> momentum_;  // rate of momentum per sole wrench
  Mat<double, 6, 6> world_[feet];
  MatrixXd torque_;  // tau = torque_ f + torque_0_
  VectorXd torque_0_, rest_;
  bool stands_[feet] = {false, false};
  int size_ = 0;                 // size of f: 6 per stance foot
  int column_[feet] = {-1, -1};  // first entry of its wrench in f
  Vec<double, 12> wrench_;       // f
  WholeBodyController::Command command_;
};

void MomentumController::eliminate_base(const DynamicsModel& model) {
  const MatrixXd& M = model.mass_matrix();
  const VectorXd& h = model.bias();
  base_factor_.compute(M.topLeftCorner<6, 6>());
  base_ = M.topRightCorner(6, n_);
  base_factor_.solve_in_place(base_);
  base_bias_ = h.head<6>();
  base_factor_.solve_in_place(base_bias_);
  mass_ = M.bottomRightCorner(n_, n_);
  mass_.noalias() -= M.bottomLeftCorner(n_, 6) * base_;
  mass_factor_.compute(mass_);
  bias_ = h.tail(n_);
  bias_.noalias() -= M.bottomLeftCorner(n_, 6) * base_bias_;
}

// Computes Lambda and the missing accelerations of the feet, then the torques as a function of the
// wrenches.
void MomentumController::set_feet(const DynamicsModel& model, const WholeBodyState& state,
                                  const WholeBodyController::Tasks& tasks) {
  const DynamicsModel::SoleMotion* soles[feet] = {&model.sole(Side::left),
                                                  &model.sole(Side::right)};
  posture_ = options_.posture * (tasks.posture - state.q) - options_.posture_damping * state.dq;
  Vec<double, 12> regularisation;
  size_ = 0;
  for (int i = 0; i < feet; ++i) {
    const DynamicsModel::SoleMotion& sole = *soles[i];
    auto J = jacobian_.middleRows<6>(6 * i);
    J = sole.jacobian.rightCols(n_);
    J.noalias() -= sole.jacobian.topLeftCorner<6, 6>() * base_;
    missing_.segment<6>(6 * i) = sole.jacobian.topLeftCorner<6, 6>() * base_bias_ - sole.drift;
    if (stands_[i])
      missing_.segment<6>(6 * i) +=
          (i == 0 ? tasks.left_hold : tasks.right_hold) - options_.stance_damping * sole.twist;
    else
      missing_.segment<6>(6 * i) += tasks.swing_acceleration;
    missing_.segment<6>(6 * i).noalias() -= J * posture_;
    const double r = stands_[i] ? options_.stance_regularisation : options_.swing_regularisation;
    regularisation.segment<6>(6 * i).setConstant(r * r);
    column_[i] = stands_[i] ? size_ : -1;
    if (stands_[i]) size_ += 6;
  }
  transfer_ = jacobian_.transpose();
  mass_factor_.solve_in_place(transfer_);
  gram_.noalias() = transfer_.transpose() * transfer_;
  gram_.diagonal() += regularisation;
  gram_factor_.compute(gram_);

  for (int i = 0; i < feet; ++i) {
    if (!stands_[i]) continue;
    world_[i] = wrench_to_world(*soles[i]);
    Mat<double, 6, 6> base = soles[i]->jacobian.topLeftCorner<6, 6>().transpose() * world_[i];
    base_factor_.solve_in_place(base);
    for (int k = 0; k < feet; ++k)
      pull_.block<6, 6>(6 * k, column_[i]).noalias() =
          soles[k]->jacobian.topLeftCorner<6, 6>() * base;
    const Mat<double, 6, 6> reaction = -world_[i];
    torque_.middleCols<6>(column_[i]).noalias() =
        jacobian_.middleRows<6>(6 * i).transpose() * reaction;
    momentum_.block<6, 6>(0, column_[i]) = wrench_to_momentum(*soles[i], model.com());
  }
  // tau_0 and Lambda^+ times the missing acceleration.
  torque_0_ = bias_;
  torque_0_.noalias() += mass_ * posture_;
  effort_of_missing_ = missing_;
  gram_factor_.solve_in_place(effort_of_missing_);
  torque_0_.noalias() += transfer_ * effort_of_missing_;
  Mat<double, 12, 12> per_wrench = pull_;
  gram_factor_.solve_in_place(per_wrench);
  torque_.leftCols(size_).noalias() -= transfer_ * per_wrench.leftCols(size_);
}

bool MomentumController::find_wrenches(const DynamicsModel& model,
                                       const WholeBodyController::Tasks& tasks) {
  command_.status = qp::QpStatus::optimal;
  command_.iterations = 0;
  command_.solve_seconds = 0.0;
  if (size_ == 0) return true;
  qp::Stage& stage = qp_.stages[0];
  stage.nx = 0;
  stage.nu = size_;
  Vec<double, 6> wanted, weight;
  wanted << tasks.force + Vec<double, 3>(0.0, 0.0, model.mass() * standard_gravity), tasks.torque;
  weight.head<3>().setConstant(options_.linear_momentum);
  weight.tail<3>().setConstant(options_.angular_momentum);
  const auto A = momentum_.topLeftCorner(6, size_);
  stage.R.topLeftCorner(size_, size_).noalias() = A.transpose() * weight.asDiagonal() * A;
  stage.r.head(size_).noalias() = -(A.transpose() * weight.cwiseProduct(wanted));
  const auto T = torque_.leftCols(size_);
  stage.R.topLeftCorner(size_, size_).noalias() += options_.torque * T.transpose() * T;
  stage.r.head(size_).noalias() += options_.torque * T.transpose() * torque_0_;
  for (int i = 0; i < feet; ++i) {
    qp::RowGroup& cone = stage.groups[i];
    cone.rows = 0;
    if (!stands_[i]) continue;
    stage.R.diagonal().segment<6>(column_[i]).array() += options_.wrench;
    stage.r.segment<6>(column_[i]) -= options_.wrench * tasks.wrenches.segment<6>(6 * i);
    keep_in_cone(cone, cones_[i], column_[i]);
  }
  const double begin = thread_microseconds();
  const qp::QpResult r = solver_->solve(qp_, point_, false);
  command_.solve_seconds = 1e-6 * (thread_microseconds() - begin);
  command_.status = r.status;
  command_.iterations = r.iterations;
  // A wrench within a hundredth of a N of the optimum is accepted too.
  if (r.status != qp::QpStatus::optimal && !(r.residual < 1e-2)) return false;
  wrench_.head(size_) = point_.stages[0].u.head(size_);
  return true;
}

// Cuts the torques, then computes the resulting accelerations of joints and feet if the ground
// responds with these wrenches.
void MomentumController::finish(const WholeBodyState& state) {
  const auto f = wrench_.head(size_);
  command_.torques = torque_0_;
  command_.torques.noalias() += torque_.leftCols(size_) * f;
  command_.torques_cut = 0;
  for (int i = 0; i < n_; ++i) {
    if (std::abs(command_.torques[i]) <= effort_[i]) continue;
    command_.torques[i] = std::clamp(command_.torques[i], -effort_[i], effort_[i]);
    ++command_.torques_cut;
  }
  command_.wrenches.setZero();
  rest_ = command_.torques - bias_;
  for (int i = 0; i < feet; ++i) {
    if (!stands_[i]) continue;
    command_.wrenches.segment<6>(6 * i) = f.segment<6>(column_[i]);
    rest_.noalias() +=
        jacobian_.middleRows<6>(6 * i).transpose() * (world_[i] * f.segment<6>(column_[i]));
  }
  mass_factor_.solve_in_place(rest_);
  command_.joint_acceleration = rest_;

  rest_ -= posture_;
  command_.stance_slip = 0.0;
  for (int i = 0; i < feet; ++i) {
    if (!stands_[i]) continue;
    Vec<double, 6> error = -missing_.segment<6>(6 * i);
    error.noalias() += jacobian_.middleRows<6>(6 * i) * rest_;
    error.noalias() += pull_.block(6 * i, 0, 6, size_) * f;
    command_.stance_slip = std::max(command_.stance_slip, error.cwiseAbs().maxCoeff());
  }
  command_.limit_excess = limit_excess(state);
}

// Largest excess of a joint acceleration over the one that reaches the joint's limit in time T,
// rad/s^2. Unlike the inverse-dynamics program, this controller keeps no margin.
double MomentumController::limit_excess(const WholeBodyState& state) const {
  const double T = options_.limit_horizon;
  double most = 0.0;
  for (int i = 0; i < n_; ++i) {
    const double ahead =
        state.q[i] + T * state.dq[i] + 0.5 * T * T * command_.joint_acceleration[i];
    most = std::max({most, lower_[i] - ahead, ahead - upper_[i]});
  }
  return 2.0 / (T * T) * most;
}

const WholeBodyController::Command& MomentumController::control(
    const DynamicsModel& model, const WholeBodyState& state,
    const WholeBodyController::Tasks& tasks) noexcept {
  stands_[0] = tasks.left_stands;
  stands_[1] = tasks.right_stands;
  eliminate_base(model);
  set_feet(model, state, tasks);
  if (find_wrenches(model, tasks)) finish(state);
  return command_;
}

}  // namespace

std::unique_ptr<WholeBodyController> make_momentum_controller(
    const FloatingRobot& robot, const ContactCone::Options& left, const ContactCone::Options& right,
    const WholeBodyController::MomentumOptions& options) {
  return std::make_unique<MomentumController>(robot, left, right, options);
}

}  // namespace saltus::robots
