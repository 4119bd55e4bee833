// The tasks of `saltus run whole_body`.
#pragma once

#include <string>
#include <vector>

#include "problems/whole_body/problem.hpp"

namespace saltus::whole_body {

/// Sizes of the tasks.
struct Sizes {
  double length = 0.15;  // of a step, m
  double height = 0.1;   // of the stair, m
  double slope = 10.0;   // of the ramp, degrees
  double turn = 45.0;    // degrees to the left
  double width = 0.14;   // between the soles, m
  int foot = 1;          // task step: 0 left, 1 right
  bool chosen = false;   // task step: the plan chooses where the foot lands
};

/// x of the edge of stair and ramp, in front of the toes at the start, m.
double edge_ahead(const Body& body);

/// Names of the tasks.
const std::vector<std::string>& task_names();

/// The task of this name.
Task task(const std::string& name, const Body& body, const Sizes& sizes);

/// A posture with the soles of the left and right foot at these places and the centre of mass at
/// `com` (m), close to the nominal one. `near` is the first guess of q.
VectorXd posture_on(const Body& body, const robots::SoleFrame places[2], const Vec<double, 2>& com,
                    const VectorXd& near);

}  // namespace saltus::whole_body
