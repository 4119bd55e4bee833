#include "saltus/robots/centroidal/centroidal_plant.hpp"

#include <array>

#include "saltus/model/make_function.hpp"
#include "saltus/robots/centroidal/centroidal.hpp"

namespace saltus::robots {
namespace {

// Exact dynamics. Inputs: contact forces and torques of left and right foot in world axes.
// Parameters: positions of the soles and the push.
struct ExactDynamics {
  double mass;

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& gamma, const Vec<S, 12>& u,
                       const Vec<S, 9>& p) const {
    const std::array<Contact<S>, 2> contacts{
        Contact<S>{p.template segment<3>(0), u.template segment<3>(0), u.template segment<3>(3)},
        Contact<S>{p.template segment<3>(3), u.template segment<3>(6), u.template segment<3>(9)}};
    return centroidal_dynamics(mass, gamma, contacts, Vec<S, 3>(p.template segment<3>(6)));
  }
};

Vec<double, 6> in_world(const CentroidalPlant::Foot& foot, const Vec<double, 6>& wrench) {
  Vec<double, 6> result = Vec<double, 6>::Zero();
  if (foot.in_contact) {
    result.head<3>() = foot.sole.rotation * wrench.head<3>();
    result.tail<3>() = foot.sole.rotation * wrench.tail<3>();
  }
  return result;
}

}  // namespace

CentroidalPlant::CentroidalPlant(double mass, const Vec<double, 9>& start,
                                 const IntegratorChoice& integrator)
    : state_(start) {
  IntervalProblem problem;
  problem.arguments = {9, 12, 9};
  problem.dynamics = make_function<9, 12, 9>(ExactDynamics{mass});
  integrator_ = integrator->make(problem);
}

IntegrationStatus CentroidalPlant::advance(double length, const Vec<double, 12>& wrenches) {
  const IntervalArguments a = integrator_->arguments();
  VectorXd w(a.size()), end(9);
  w << state_, in_world(left, wrenches.head<6>()), in_world(right, wrenches.tail<6>()),
      left.sole.position, right.sole.position, push, 0.0, length;
  const IntegrationStatus status = integrator_->value(w.data(), end.data());
  if (status == IntegrationStatus::success) state_ = end;
  return status;
}

Vec<double, 3> CentroidalPlant::contact_force(const Vec<double, 12>& wrenches) const {
  return in_world(left, wrenches.head<6>()).head<3>() +
         in_world(right, wrenches.tail<6>()).head<3>();
}

}  // namespace saltus::robots
