#include "benchmarks/pendulum_walker.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/core/clock.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::push_recovery {
namespace {

using robots::walking::StepSituation;

using Vector2 = Vec<double, 2>;
using Vector3 = Vec<double, 3>;

// Advances by h along the quintic that reaches rest at `to` in `left` seconds.
struct SwingFoot {
  Vector3 position, velocity = Vector3::Zero(), acceleration = Vector3::Zero();

  void advance(const Vector3& to, double left, double h) {
    const double T = left;
    const Vector3 d = to - position;
    const Vector3 a3 = (20 * d - 12 * velocity * T - 3 * acceleration * T * T) / (2 * T * T * T);
    const Vector3 a4 =
        (-30 * d + 16 * velocity * T + 3 * acceleration * T * T) / (2 * T * T * T * T);
    const Vector3 a5 = (12 * d - 6 * velocity * T - acceleration * T * T) / (2 * T * T * T * T * T);
    position += h * (velocity + h * (0.5 * acceleration + h * (a3 + h * (a4 + h * a5))));
    velocity += h * (acceleration + h * (3 * a3 + h * (4 * a4 + h * 5 * a5)));
    acceleration += h * (6 * a3 + h * (12 * a4 + h * 20 * a5));
  }
};

class Walker {
 public:
  Walker(StepChoice& planner, const WalkerOptions& options, std::span<const PendulumPush> pushes)
      : planner_(planner),
        o_(options),
        pushes_(pushes),
        omega_(pendulum_frequency(options.height)) {
    now_.period = o_.period;
    now_.mass = o_.mass;
    now_.omega = omega_;
    now_.left.sole = robots::flat_sole(Vector3::Zero());
    now_.right.sole = robots::flat_sole({0.0, -o_.apart, 0.0});
    now_.left.stands = o_.left_stands;
    now_.right.stands = o_.right_stands;
    com_ = now_.left.stands && now_.right.stands
               ? Vector2(0.5 * (centre(robots::Side::left) + centre(robots::Side::right)))
               : centre(now_.left.stands ? robots::Side::left : robots::Side::right);
    capture_ = com_;
  }

  WalkerRun run(const std::function<void(const StepSituation&, const StepPlan&)>& observe) {
    constexpr double fallen = 1.5;  // m
    for (long k = 0; static_cast<double>(k) * o_.period < o_.duration; ++k) {
      now_.time = static_cast<double>(k) * o_.period;
      measure();
      const double begin = thread_microseconds();
      const StepPlan& plan = planner_.plan(now_);
      result_.seconds.push_back(1e-6 * (thread_microseconds() - begin));
      result_.iterations.push_back(planner_.iterations());
      if (observe) observe(now_, plan);
      lift_off(plan);
      advance_pendulum();
      advance_foot(plan);
      if (!((capture_ - com_).norm() < fallen)) return std::move(result_);
    }
    constexpr double at_rest = 0.02;  // m, from the capture point to the CoM
    const Vector2 under = nearest_support(capture_);
    result_.recovered = (capture_ - com_).norm() < at_rest && (capture_ - under).norm() < 1e-3;
    return std::move(result_);
  }

 private:
  Vector2 centre(robots::Side side) const {
    const robots::SoleFrame& sole = now_.foot(side).sole;
    return sole.position.head<2>() + sole.rotation.topLeftCorner<2, 2>() * o_.centres.of(side);
  }

  void measure() {
    const double lever = o_.mass * o_.height * omega_;
    now_.gamma << com_, o_.height, omega_ * (capture_ + lent_ - com_), 0.0, lever * lent_[1],
        -lever * lent_[0], 0.0;
  }

  void lift_off(const StepPlan& plan) {
    if (plan.count == 0) return;
    StepSituation::Foot& foot = now_.foot(plan.steps[0].foot);
    if (foot.swings() || plan.steps[0].lift_off > now_.time + o_.period) return;
    foot.stands = false;
    foot.lifted_off = now_.time;
    swing_ = SwingFoot{foot.sole.position};
    ++result_.steps;
  }

  Vector2 nearest_support(const Vector2& point) const {
    const Vector2 a = centre(now_.left.stands ? robots::Side::left : robots::Side::right),
                  b = centre(now_.right.stands ? robots::Side::right : robots::Side::left);
    const Vector2 along = b - a;
    const double share = along.squaredNorm() > 0.0
                             ? std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0)
                             : 0.0;
    const Vector2 middle = a + share * along;
    const Mat<double, 2, 2> axes =
        now_.foot(now_.left.stands ? robots::Side::left : robots::Side::right)
            .sole.rotation.topLeftCorner<2, 2>();
    const Vector2 beside = axes.transpose() * (point - middle);
    return middle + axes * beside.cwiseMax(-o_.half_sole).cwiseMin(o_.half_sole);
  }

  void advance_pendulum() {
    constexpr int pieces = 20;
    const double h = o_.period / pieces;
    for (int i = 0; i < pieces; ++i) {
      const double t = now_.time + i * h;
      Vector2 force = Vector2::Zero();
      for (const PendulumPush& push : pushes_)
        if (t > push.start - 1e-9 && t < push.start + push.duration - 1e-9)
          force += push.impulse / push.duration;
      const Vector2 cop = nearest_support(planner_.pressure());
      const Vector2 rate = planner_.lent_rate().cwiseMax(-o_.lent_rate).cwiseMin(o_.lent_rate);
      const Vector2 lent = (lent_ + h * rate).cwiseMax(-o_.lent).cwiseMin(o_.lent);
      const Vector2 full = capture_ + lent_;
      com_ += h * omega_ * (full - com_);
      capture_ += h * (omega_ * (full - cop) + force / (o_.mass * omega_));
      lent_ = lent;
    }
  }

  void advance_foot(const StepPlan& plan) {
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      StepSituation::Foot& foot = now_.foot(side);
      if (!foot.swings() || plan.count == 0) continue;
      const double left = plan.steps[0].landing - now_.time;
      if (left <= o_.period + 1e-9) {
        foot.sole.position = plan.steps[0].place;
        if (plan.steps[0].heading)
          foot.sole = robots::flat_sole(plan.steps[0].place, *plan.steps[0].heading);
        foot.stands = true;
        foot.lifted_off = infinity;
        foot.velocity.setZero();
        if (result_.steps == 1 && !pushes_.empty())
          result_.first_landing = plan.steps[0].landing - pushes_.front().start;
        continue;
      }
      swing_.advance(plan.steps[0].place, left, o_.period);
      foot.sole.position = swing_.position;
      foot.velocity = swing_.velocity;
      result_.foot_speed = std::max(result_.foot_speed, swing_.velocity.norm());
    }
  }

  StepChoice& planner_;
  WalkerOptions o_;
  std::span<const PendulumPush> pushes_;
  double omega_;
  StepSituation now_;
  Vector2 com_, capture_, lent_ = Vector2::Zero();
  SwingFoot swing_;
  WalkerRun result_;
};

}  // namespace

WalkerRun walk(StepChoice& planner, const WalkerOptions& options,
               std::span<const PendulumPush> pushes,
               const std::function<void(const StepSituation&, const StepPlan&)>& observe) {
  return Walker(planner, options, pushes).run(observe);
}

}  // namespace saltus::push_recovery
