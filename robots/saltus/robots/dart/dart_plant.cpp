#include "saltus/robots/dart/dart_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/bullet/BulletCollisionDetector.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/collision/fcl/FCLCollisionDetector.hpp>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/DegreeOfFreedom.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_skeleton.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots {
namespace {

namespace dd = ::dart::dynamics;
namespace dc = ::dart::collision;

::dart::collision::CollisionDetectorPtr detector(DartOptions::Collision choice) {
  switch (choice) {
    case DartOptions::Collision::dart:
      return dc::DARTCollisionDetector::create();
    case DartOptions::Collision::fcl:
      return dc::FCLCollisionDetector::create();
    case DartOptions::Collision::bullet:
      return dc::BulletCollisionDetector::create();
    case DartOptions::Collision::ode:
      return dc::OdeCollisionDetector::create();
  }
  return nullptr;
}

const char* describe(DartOptions::Collision choice) {
  constexpr const char* names[] = {"DART's own", "FCL", "Bullet", "ODE"};
  return names[static_cast<int>(choice)];
}

double coefficient(const DartOptions& options, double friction) {
  return options.cone == DartOptions::Friction::box ? friction : friction * std::sqrt(0.5);
}

dd::SkeletonPtr ground(const DartOptions& options) {
  dd::SkeletonPtr skeleton = dd::Skeleton::create("ground");
  dd::BodyNode* body = skeleton->createJointAndBodyNodePair<dd::WeldJoint>().second;
  for (const GroundBox& box : ground_boxes(options)) {
    if (box.is_soft) continue;
    dd::ShapeNode* shape = body->createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(
        std::make_shared<dd::BoxShape>(box.size));
    shape->setRelativeTransform(box.pose);
    shape->getDynamicsAspect()->setFrictionCoeff(coefficient(options, box.friction));
  }
  return skeleton;
}

void expect_capsules(DartOptions::Collision choice) {
  if (choice != DartOptions::Collision::bullet && choice != DartOptions::Collision::ode)
    throw InputError(
        fmt::format("the {} collision detector does not support capsules, the shapes of the limbs; "
                    "set dart.collision to bullet or ode, or set self_collision=false",
                    describe(choice)));
}

class DartPlant final : public Plant {
 public:
  DartPlant(const FloatingRobot& robot, const DartOptions& options)
      : options_(options),
        world_(::dart::simulation::World::create()),
        view_(dart_engine::make_skeleton(robot), robot),
        feet_{robot.left_sole, robot.right_sole},
        torques_(VectorXd::Zero(robot.joints())) {
    const dd::SkeletonPtr& skeleton = view_.skeleton();
    if (options.self_collision) {
      expect_capsules(options.collision);
      dart_engine::add_capsules(robot, *skeleton);
    }
    // The friction of a contact is the smaller one: that of the ground.
    const double largest = std::max(options.friction, options.ground.friction);
    for (dd::BodyNode* body : skeleton->getBodyNodes())
      for (std::size_t i = 0; i < body->getNumShapeNodes(); ++i)
        if (dd::DynamicsAspect* surface = body->getShapeNode(i)->getDynamicsAspect())
          surface->setFrictionCoeff(coefficient(options, largest));
    for (int i = 0; i < robot.joints(); ++i)
      skeleton->getDof(view_.dof(6 + i))->setDampingCoefficient(options.joint_friction);
    world_->setGravity({0.0, 0.0, -standard_gravity});
    world_->setTimeStep(options.step);
    auto lcp = options.lcp == DartOptions::Lcp::dantzig
                   ? ::dart::constraint::BoxedLcpSolverPtr(
                         std::make_shared<::dart::constraint::DantzigBoxedLcpSolver>())
                   : std::make_shared<::dart::constraint::PgsBoxedLcpSolver>();
    world_->setConstraintSolver(
        std::make_unique<::dart::constraint::BoxedLcpConstraintSolver>(std::move(lcp)));
    world_->getConstraintSolver()->setCollisionDetector(detector(options.collision));
    if (options.self_collision)
      world_->getConstraintSolver()->getCollisionOption().collisionFilter =
          std::make_shared<dart_engine::CapsuleFilter>(robot, *skeleton);
    ground_ = ground(options);
    world_->addSkeleton(ground_);
    world_->addSkeleton(skeleton);
    view_.read(state_);
  }

  void reset(const WholeBodyState& state) override {
    world_->reset();
    view_.skeleton()->clearExternalForces();
    torques_.setZero();
    view_.write(state);
    view_.read(state_);
    contacts_[0] = contacts_[1] = {};
  }
  void set_torques(const VectorXd& torques) override { torques_ = torques; }
  void set_rotor_inertias(const VectorXd& inertias) override { view_.set_rotor_inertias(inertias); }
  void push(int body, const Vec<double, 3>& force, const Vec<double, 3>& point) override {
    view_.body(body)->addExtForce(force, point, /*isForceLocal=*/false, /*isOffsetLocal=*/true);
  }

  void step() override {
    for (int i = 0; i < view_.joints(); ++i)
      view_.skeleton()->setForce(view_.dof(6 + i), torques_[i]);
    world_->step();
    view_.read(state_);
    read_contacts();
  }

  double time() const override { return world_->getTime(); }
  const WholeBodyState& state() const override { return state_; }
  const WholeBodyEstimate::Contact& contact(Side side) const override {
    return contacts_[side == Side::left ? 0 : 1];
  }
  std::string name() const override {
    return fmt::format(
        "DART {}.{}.{}, {} collision detection, {} LCP solver", DART_MAJOR_VERSION,
        DART_MINOR_VERSION, DART_PATCH_VERSION, describe(options_.collision),
        options_.lcp == DartOptions::Lcp::dantzig ? "Dantzig's" : "projected Gauss-Seidel");
  }

 private:
  // Forces belong to the state before the step; the soles have hardly moved since.
  void read_contacts() {
    contacts_[0] = contacts_[1] = {};
    for (const dc::Contact& c : world_->getLastCollisionResult().getContacts()) {
      const dd::BodyNode* first = body_of(c.collisionObject1);
      const dd::BodyNode* second = body_of(c.collisionObject2);
      for (int foot = 0; foot < 2; ++foot) {
        const dd::BodyNode* body = view_.body(feet_[foot].body);
        if (first != body && second != body) continue;
        if (!is_ground(first) && !is_ground(second)) continue;  // contact of two limbs
        const Vec<double, 3> force = first == body ? c.force : Vec<double, 3>(-c.force);
        const Vec<double, 3> origin = (body->getWorldTransform() * feet_[foot].pose).translation();
        contacts_[foot].touches = true;
        contacts_[foot].wrench.head<3>() += force;
        contacts_[foot].wrench.tail<3>() += (c.point - origin).cross(force);
      }
    }
  }
  bool is_ground(const dd::BodyNode* body) const { return body == ground_->getBodyNode(0); }
  static const dd::BodyNode* body_of(const dc::CollisionObject* object) {
    return object->getShapeFrame()->asShapeNode()->getBodyNodePtr().get();
  }

  DartOptions options_;
  ::dart::simulation::WorldPtr world_;
  dart_engine::SkeletonView view_;
  dd::SkeletonPtr ground_;
  FloatingRobot::Frame feet_[2];
  VectorXd torques_;
  WholeBodyState state_;
  WholeBodyEstimate::Contact contacts_[2];
};

}  // namespace

std::unique_ptr<Plant> make_dart_plant(const FloatingRobot& robot, const DartOptions& options) {
  return std::make_unique<DartPlant>(robot, options);
}

}  // namespace saltus::robots
