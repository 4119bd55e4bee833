// Sizes, limits and weights of the step problem; step_problem.cpp contains its mathematics.
#pragma once

#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::push_recovery {

inline constexpr int most_planned_steps = 3;

/// Parameters of the step problem that change in each tick. Frame: origin at the centre of the
/// stance sole, x forward, y towards the foot that steps first (mirrored on the right foot); m, s.
template <class S>
struct StepNow {
  S omega = 4.3;                        ///< sqrt(g / z), 1/s
  Vec<S, 2> other = Vec<S, 2>::Zero();  ///< centre of the other sole in contact, else zero
  /// Supported parts of the stance sole and of the other one: centre relative to that of the sole,
  /// and the parts of the half sizes without support. Zero: the whole sole is supported. Both are
  /// equal if only the stance foot stands.
  Vec<S, 4> stance_support = Vec<S, 4>::Zero(), other_support = Vec<S, 4>::Zero();
  Vec<S, 2> swing = Vec<S, 2>::Zero();   ///< start of the swing of the foot that steps first
  Vec<S, 2> aim = Vec<S, 2>::Zero();     ///< its current target; before a swing, equal to `swing`
  S swung = 0.0;                         ///< time since its lift-off, s
  Vec<S, 2> stride = Vec<S, 2>::Zero();  ///< desired place relative to the previous foot, at rest
  /// Desired displacement of the feet between landings, (x, y) of each step.
  Vec<S, 2 * most_planned_steps> drift = Vec<S, 2 * most_planned_steps>::Zero();

  using Entries = ParameterEntries<&StepNow::omega, &StepNow::other, &StepNow::stance_support,
                                   &StepNow::other_support, &StepNow::swing, &StepNow::aim,
                                   &StepNow::swung, &StepNow::stride, &StepNow::drift>;
};

inline constexpr int reach_rows = 8;  ///< sides of the polygon of reach

/// Weights. Each residual is divided by its unit, so that one unit at weight 1 costs 1/2.
struct StepWeights {
  double capture = 1e3;   ///< violation of the terminal set, 1/m (exact penalty)
  double reach = 1e3;     ///< violation of the reach of legs or swing foot speed, 1/m
  double rest = 1.0;      ///< final rest at the border of the soles instead of their middle
  double side = 0.2;      ///< final rest above one foot instead of midway between both
  double duration = 1.0;  ///< swing duration 0.1 s from the nominal one
  double stride = 1.0;    ///< step place 0.1 m from the nominal one
  double support = 0.0;   ///< double support 0.1 s from the nominal one; 0: off
  double pressure = 1.0;  ///< per s, centre of pressure at the border of the sole
  double momentum = 3.0;  ///< per s, angular momentum at its limit
  double torque = 0.3;    ///< per s, rate of angular momentum at its limit
};

/// Supported part of a sole for the centre of pressure.
template <class S>
struct SupportedSole {
  Vec<S, 2> centre, half;  ///< centre and half sizes, m
};

/// The supported part of a sole at `centre` with half sizes `sole`. `support`: as in StepNow.
template <class S>
SupportedSole<S> supported(const Vec<S, 2>& centre, const Vec<S, 4>& support,
                           const Vec<double, 2>& sole) {
  return {centre + support.template head<2>(), sole.cast<S>() - support.template tail<2>()};
}

/// Point in the hull of two soles: on the line between their centres, `side` from -1 (a) to 1 (b),
/// and off it by up to half a sole, which `off` in [-1, 1] gives. The hull of two rectangles with
/// parallel sides contains no other points.
template <class S>
Vec<S, 2> in_hull(const SupportedSole<S>& a, const SupportedSole<S>& b, const S& side,
                  const Vec<S, 2>& off) {
  Vec<S, 2> point;
  for (int i = 0; i < 2; ++i)
    point[i] = 0.5 * (a.centre[i] + b.centre[i] + side * (b.centre[i] - a.centre[i])) +
               0.5 * (a.half[i] + b.half[i] + side * (b.half[i] - a.half[i])) * off[i];
  return point;
}

struct StepModel {
  Vec<double, 2> sole{0.07, 0.03};           ///< half sizes for the centre of pressure, m;
  Vec<double, 2> standing_sole{0.07, 0.03};  ///< the same without a further step, when
                                             ///< no reserve is needed
  double lent = 0.02;      ///< bound on eta: H / (m z omega) at the largest |H|, m
  double lent_rate = 0.2;  ///< m/s
  /// Centre of a landing foot relative to that of the stance foot, (forward, away from it), m.
  robots::SupportPolygon::HalfPlanes reach;
  /// Centres of both feet relative to the CoM at a landing, (forward, to their own side), m.
  robots::SupportPolygon::HalfPlanes leg;
  double swing_speed = 1.2;                   ///< largest speed of the swing foot, m/s
  Bounds swing = between(0.3, 0.9);           ///< from lift-off to landing, s
  double usual_swing = 0.6;                   ///< s
  Bounds double_support = between(0.1, 0.6);  ///< between two steps, s
  Bounds unloading = between(0.05, 0.5);      ///< before the first step from two feet, s
  double usual_support = 0.1;  ///< nominal time from landing to lift-off while walking, s
  double standing = 0.6;       ///< horizon without steps, s
  StepWeights weights;
};

inline constexpr int step_states = 7;

/// Step problem with 0 to most_planned_steps `steps`. `from_two_feet`: the first foot is still on
/// the ground. Data "now". The initial state is (com, xi at rest, eta, time since lift-off; on two
/// feet: time since landing).
OptimalControlProblem step_problem(const StepModel& model, int steps, bool from_two_feet);

}  // namespace saltus::push_recovery
