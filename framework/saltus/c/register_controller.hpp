// Registers a controller of a plugin under a name, for hosts that use saltus/c/saltus_c.h.
//
//   namespace {
//   RecedingHorizonController make_cart(ControllerOptions options) {
//     options.period = 0.02;
//     return {MultipleShooting(cart(), {.integrator = runge_kutta4()}), std::move(options)};
//   }
//   const RegisterController cart_is_registered("cart", make_cart);
//   }  // namespace
#pragma once

#include "saltus/mpc/receding_horizon.hpp"

namespace saltus {

/// Makes a controller from these options. It may change them. `send` is set for saltus_on_input().
using ControllerFactory = RecedingHorizonController (*)(ControllerOptions options);

/// A registration, which lasts as long as this object. Give the object static storage duration in
/// the plugin. Names are unique among all plugins that share the library saltus_c.
class RegisterController {
 public:
  /// Keeps both pointers. The name must outlive the object. Does not allocate.
  RegisterController(const char* name, ControllerFactory make) noexcept;
  ~RegisterController();
  RegisterController(const RegisterController&) = delete;
  RegisterController& operator=(const RegisterController&) = delete;

  /// Name of the controller.
  const char* name() const { return name_; }
  /// Its factory.
  ControllerFactory factory() const { return make_; }
  /// The registration before this one, or nullptr.
  const RegisterController* previous() const { return previous_; }

 private:
  const char* name_;
  ControllerFactory make_;
  RegisterController* previous_;
};

}  // namespace saltus
