// A problem on a biped that the program can configure: its settings have keys, and it can be
// copied.
#pragma once

#include <memory>

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus {
class Settings;
}

namespace saltus::robots::walking {

/// A problem on a biped for `saltus run`, `saltus map` and `saltus robot`.
class ConfigurableBiped : public BipedProblem {
 public:
  /// A copy that can be run at the same time as this one.
  virtual std::unique_ptr<ConfigurableBiped> clone() const = 0;
  /// Binds every key to its field of this object.
  virtual void declare(Settings& settings) = 0;
};

}  // namespace saltus::robots::walking
