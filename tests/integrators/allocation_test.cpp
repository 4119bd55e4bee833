// The fixed-step schemes do not allocate after construction. The SUNDIALS schemes do not allocate
// after the first call of each kind.
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "tests/integrators/hybrid_problems.hpp"
#include "tests/integrators/support.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

using namespace test;

// All calls of the interface with varying lengths, so that no cache answers them.
class Caller {
 public:
  Caller(Integrator& integrator, const VectorXd& w)
      : integrator_(integrator),
        w_(w),
        end_(integrator.outputs()),
        weights_(VectorXd::Ones(integrator.outputs())),
        derivative_(integrator.outputs(), w.size()),
        hessian_(w.size(), w.size()) {}

  void call() {
    w_[integrator_.arguments().h()] += 0.005;
    integrator_.value(w_.data(), end_.data());
    integrator_.jacobian(w_.data(), end_.data(), derivative_);
    if (!integrator_.has_hessian()) return;
    integrator_.hessian(w_.data(), weights_.data(), hessian_, Curvature::exact);
    integrator_.hessian(w_.data(), weights_.data(), hessian_, Curvature::gauss_newton);
  }

  long allocations_of_ten_calls() {
    const saltus::testing::AllocationCount count;
    for (int i = 0; i < 10; ++i) call();
    return count.made();
  }

 private:
  Integrator& integrator_;
  VectorXd w_, end_, weights_;
  MatrixXd derivative_, hessian_;
};

TEST(Allocations, RungeKuttaDoesNotAllocate) {
  std::vector<IntegratorChoice> schemes{runge_kutta4(), runge_kutta4({.steps = 4}), runge_kutta8(),
                                        implicit_midpoint({.steps = 2})};
  for (const int stages : {1, 2, 3, 4}) {
    schemes.push_back(gauss_legendre({.stages = stages, .steps = 2}));
    schemes.push_back(radau_iia({.stages = stages, .steps = 2}));
  }
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    for (const auto& scheme : schemes) {
      const auto integrator = scheme->make(coupled_problem(shape));
      EXPECT_EQ(Caller(*integrator, coupled_point(shape)).allocations_of_ten_calls(), 0)
          << scheme->name();
    }
  }
}

TEST(Allocations, EventsDoNotAllocateAfterTheFirstSecondDerivatives) {
  for (const auto& scheme : {runge_kutta4({.steps = 3}), radau_iia({.steps = 3})}) {
    const auto integrator = scheme->make(bouncing_ball());
    const VectorXd w = vec({1.0, 0.2, 9.81, 0.8, 0.1, 1.4});  // two impacts
    Caller caller(*integrator, w);
    caller.call();
    EXPECT_EQ(caller.allocations_of_ten_calls(), 0) << scheme->name();
  }
}

TEST(Allocations, ZeroOrderHoldDoesNotAllocate) {
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    for (const bool parameters : {false, true}) {
      const auto integrator =
          zero_order_hold()->make(affine_problem(shape, parameters, /*time=*/true));
      EXPECT_EQ(Caller(*integrator, affine_point(shape, 0.3)).allocations_of_ten_calls(), 0);
    }
  }
}

TEST(Allocations, SundialsDoesNotAllocateAfterTheFirstCalls) {
  const InputShape shape = InputShape::linear;
  for (const auto& scheme :
       {cvodes(), cvodes({.method = CvodesOptions::Method::Adams}), arkode(),
        arkode({.method = ArkodeOptions::Method::DiagonallyImplicit, .order = 4})}) {
    const auto integrator = scheme->make(coupled_problem(shape));
    Caller caller(*integrator, coupled_point(shape));
    caller.call();
    EXPECT_EQ(caller.allocations_of_ten_calls(), 0) << scheme->name();
  }
}

}  // namespace
}  // namespace saltus
