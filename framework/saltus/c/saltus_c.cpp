// The C interface: checks arguments, calls the controller, and turns exceptions into a status and a
// text.
#include "saltus/c/saltus_c.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/c/register_controller.hpp"
#include "saltus/core/error.hpp"

// In one object, so that a registration links all functions of the interface.
namespace saltus {
namespace {

// Registrations form a list from the last one to the first. Plugins are loaded and unloaded in any
// thread.
constinit std::mutex guard;
constinit RegisterController* last = nullptr;

}  // namespace

RegisterController::RegisterController(const char* name, ControllerFactory make) noexcept
    : name_(name), make_(make), previous_(nullptr) {
  const std::scoped_lock lock(guard);
  previous_ = std::exchange(last, this);
}

RegisterController::~RegisterController() {
  const std::scoped_lock lock(guard);
  RegisterController** link = &last;
  while (*link != nullptr && *link != this) link = &(*link)->previous_;
  if (*link == this) *link = previous_;
}

}  // namespace saltus

struct saltus_controller {
  // True after a tick until a change, which report() would mix with the plan.
  bool has_plan = false;
  const saltus::ControlTick* last_tick = nullptr;  // owned by the controller
  saltus_input_callback callback = nullptr;
  void* context = nullptr;
  std::optional<saltus::RecedingHorizonController> controller;
  std::array<char, 1024> error{};
};

namespace {

using saltus::ControlTick;
using saltus::Provenance;
using saltus::RecedingHorizonController;
using saltus::RegisterController;

static_assert(int{SALTUS_OPTIMAL} == int(Provenance::optimal) &&
              int{SALTUS_FEASIBLE} == int(Provenance::feasible) &&
              int{SALTUS_SHIFTED} == int(Provenance::shifted) &&
              int{SALTUS_FALLBACK} == int(Provenance::fallback) &&
              int{SALTUS_STEP} == int(Provenance::step) && saltus::provenances == 5);

template <class... Arguments>
saltus_status fail(saltus_controller& handle, saltus_status status,
                   fmt::format_string<Arguments...> text, Arguments&&... arguments) noexcept {
  try {
    const auto end = fmt::format_to_n(handle.error.data(), handle.error.size() - 1, text,
                                      std::forward<Arguments>(arguments)...);
    *end.out = '\0';
  } catch (...) {  // formatting needs memory
    handle.error[0] = '\0';
  }
  return status;
}

// Exceptions of the body become a status.
template <class Body>
saltus_status guarded(saltus_controller& handle, Body&& body) noexcept {
  try {
    return body();
  } catch (const saltus::DefinitionError& error) {
    return fail(handle, SALTUS_BAD_DEFINITION, "{}", error.what());
  } catch (const std::exception& error) {
    return fail(handle, SALTUS_FAILURE, "{}", error.what());
  } catch (...) {
    return fail(handle, SALTUS_FAILURE, "an exception that is not a std::exception");
  }
}

// Calls the body with the controller.
template <class Body>
saltus_status call(saltus_controller* handle, Body&& body) noexcept {
  if (handle == nullptr) return SALTUS_BAD_ARGUMENT;
  if (!handle->controller)
    return fail(*handle, SALTUS_BAD_DEFINITION, "this controller could not be created");
  handle->error[0] = '\0';
  return guarded(*handle, [&] { return body(*handle->controller); });
}

saltus_tick tick_of(const ControlTick& tick) {
  return {.time = tick.time,
          .provenance = static_cast<saltus_provenance>(tick.provenance),
          .pieces = static_cast<int>(tick.input.size()),
          .iterations = tick.iterations,
          .objective = tick.objective,
          .kkt = tick.kkt,
          .violation = tick.violation,
          .preparation = tick.preparation,
          .feedback = tick.feedback,
          .check = tick.check,
          .solve = saltus::describe(tick.status)};
}

Eigen::Map<const saltus::VectorXd> vector(const double* values, int count) {
  return {values, count};
}

// Number of registrations with this name, and the factory of the last of them.
std::pair<int, saltus::ControllerFactory> find(std::string_view name) {
  const std::scoped_lock lock(saltus::guard);
  std::pair<int, saltus::ControllerFactory> found{0, nullptr};
  for (const RegisterController* r = saltus::last; r != nullptr; r = r->previous())
    if (name == r->name()) found = {found.first + 1, r->factory()};
  return found;
}

// Options that call the host as soon as the input is known.
saltus::ControllerOptions options_of(saltus_controller& handle) {
  saltus::ControllerOptions options;
  options.send = [&handle](const ControlTick& tick) {
    handle.last_tick = &tick;  // for saltus_read_piece()
    if (handle.callback == nullptr) return;
    const saltus_tick copy = tick_of(tick);
    handle.callback(handle.context, &copy);
  };
  return options;
}

// The largest size of a phase.
int largest(const std::vector<saltus::PhaseDefinition>& phases, int saltus::Arguments::*size) {
  int found = 0;
  for (const saltus::PhaseDefinition& phase : phases) found = std::max(found, phase.sizes.*size);
  return found;
}

// Writes a vector to a row, and NaN to the rest of the row.
void write_row(double* rows, int row, int columns, const saltus::VectorXd& values) {
  if (rows == nullptr) return;
  double* to = rows + std::ptrdiff_t{row} * columns;
  std::fill_n(to, columns, std::numeric_limits<double>::quiet_NaN());
  std::copy_n(values.data(), std::min<Eigen::Index>(values.size(), columns), to);
}

}  // namespace

extern "C" {

int saltus_interface_version(void) { return SALTUS_INTERFACE_VERSION; }

const char* saltus_version(void) { return SALTUS_VERSION; }

int saltus_controllers(void) {
  const std::scoped_lock lock(saltus::guard);
  int count = 0;
  for (const RegisterController* r = saltus::last; r != nullptr; r = r->previous()) ++count;
  return count;
}

const char* saltus_controller_name(int i) {
  const std::scoped_lock lock(saltus::guard);
  const RegisterController* r = saltus::last;
  for (int k = 0; k < i && r != nullptr; ++k) r = r->previous();
  return i >= 0 && r != nullptr ? r->name() : nullptr;
}

saltus_status saltus_create(const char* name, saltus_controller** controller) {
  if (controller == nullptr) return SALTUS_BAD_ARGUMENT;
  auto* const handle = *controller = new (std::nothrow) saltus_controller;
  if (handle == nullptr) return SALTUS_FAILURE;
  if (name == nullptr) return fail(*handle, SALTUS_BAD_ARGUMENT, "saltus_create: no name");
  return guarded(*handle, [&] {
    const auto [count, make] = find(name);
    if (count == 0 || make == nullptr)
      return fail(*handle, SALTUS_UNKNOWN_NAME, "no controller '{}' is registered", name);
    if (count > 1)
      return fail(*handle, SALTUS_BAD_DEFINITION, "{} controllers '{}' are registered", count,
                  name);
    handle->controller.emplace(make(options_of(*handle)));
    return SALTUS_OK;
  });
}

void saltus_destroy(saltus_controller* controller) { delete controller; }

const char* saltus_error(const saltus_controller* controller) {
  return controller == nullptr ? "no controller: a null pointer" : controller->error.data();
}

saltus_status saltus_read_sizes(saltus_controller* controller, saltus_sizes* sizes) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    if (sizes == nullptr)
      return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_read_sizes: no sizes");
    const auto& phases = mpc.problem().phases();
    *sizes = {.states = phases.front().sizes.nx,
              .inputs = phases.front().sizes.nu,
              .plan_states = largest(phases, &saltus::Arguments::nx),
              .plan_inputs = largest(phases, &saltus::Arguments::nu),
              .period = mpc.period()};
    return SALTUS_OK;
  });
}

saltus_status saltus_set_data(saltus_controller* controller, const char* name, const double* values,
                              int count) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    if (name == nullptr || values == nullptr || count < 1)
      return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_set_data: no name or no values");
    mpc.set_data(name, vector(values, count));
    controller->has_plan = false;
    return SALTUS_OK;
  });
}

saltus_status saltus_retime(saltus_controller* controller, const char* event, double time) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    if (event == nullptr) return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_retime: no event");
    mpc.retime(event, time);
    controller->has_plan = false;
    return SALTUS_OK;
  });
}

saltus_status saltus_set_previous_input(saltus_controller* controller, const double* input,
                                        int count) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    if (input == nullptr || count < 1)
      return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_set_previous_input: no input");
    mpc.set_previous_input(vector(input, count));
    controller->has_plan = false;
    return SALTUS_OK;
  });
}

saltus_status saltus_on_input(saltus_controller* controller, saltus_input_callback callback,
                              void* context) {
  return call(controller, [&](RecedingHorizonController&) {
    controller->callback = callback;
    controller->context = context;
    return SALTUS_OK;
  });
}

saltus_status saltus_prepare(saltus_controller* controller, double time) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    mpc.prepare(time);
    controller->has_plan = false;
    return SALTUS_OK;
  });
}

saltus_status saltus_feedback(saltus_controller* controller, const double* state, int count,
                              saltus_tick* tick) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    const int states = mpc.problem().phases().front().sizes.nx;
    const bool fits = count == states;
    // An empty measurement is none.
    controller->last_tick = &mpc.feedback(vector(state, state != nullptr && fits ? count : 0));
    controller->has_plan = true;
    if (tick != nullptr) *tick = tick_of(*controller->last_tick);
    if (state != nullptr && !fits)
      return fail(*controller, SALTUS_BAD_ARGUMENT,
                  "saltus_feedback: the state has {} entries, expected {}", count, states);
    return SALTUS_OK;
  });
}

saltus_status saltus_read_piece(saltus_controller* controller, int i, double* start, double* length,
                                double* input, int capacity, int* count) {
  return call(controller, [&](RecedingHorizonController&) {
    if (start == nullptr || length == nullptr || input == nullptr || count == nullptr)
      return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_read_piece: a null pointer");
    if (controller->last_tick == nullptr)
      return fail(*controller, SALTUS_NO_PLAN, "saltus_read_piece: there was no tick yet");
    const saltus::HeldInput& pieces = controller->last_tick->input;
    if (i < 0 || i >= static_cast<int>(pieces.size()))
      return fail(*controller, SALTUS_BAD_ARGUMENT,
                  "saltus_read_piece: there is no piece {}, the input has {}", i, pieces.size());
    const saltus::HeldInput::Piece& piece = pieces[static_cast<std::size_t>(i)];
    if (capacity < piece.size)
      return fail(*controller, SALTUS_BAD_ARGUMENT,
                  "saltus_read_piece: the input has {} entries, the array {}", piece.size,
                  capacity);
    *start = piece.start;
    *length = piece.length;
    *count = piece.size;
    std::copy_n(piece.values.data(), piece.size, input);
    return SALTUS_OK;
  });
}

saltus_status saltus_read_plan(saltus_controller* controller, double* times, int* phases,
                               double* states, double* inputs, int capacity, int* rows) {
  return call(controller, [&](RecedingHorizonController& mpc) {
    if (times == nullptr || rows == nullptr)
      return fail(*controller, SALTUS_BAD_ARGUMENT, "saltus_read_plan: a null pointer");
    if (!controller->has_plan)
      return fail(*controller, SALTUS_NO_PLAN,
                  "saltus_read_plan: there was no tick, or the controller was changed after it");
    const saltus::Solution plan = mpc.report();
    const auto& pieces = plan.trajectory.pieces();
    const auto ends_phase = [&](std::size_t k) {
      return k + 1 == pieces.size() || pieces[k + 1].phase != pieces[k].phase;
    };
    *rows = 0;
    for (std::size_t k = 0; k < pieces.size(); ++k) *rows += ends_phase(k) ? 2 : 1;
    if (*rows > capacity)
      return fail(*controller, SALTUS_BAD_ARGUMENT,
                  "saltus_read_plan: the plan has {} rows, the arrays {}", *rows, capacity);
    const auto& definitions = mpc.problem().phases();
    const int nx = largest(definitions, &saltus::Arguments::nx);
    const int nu = largest(definitions, &saltus::Arguments::nu);
    int row = 0;
    const auto write = [&](const saltus::Trajectory::Piece& piece, double t,
                           const saltus::VectorXd& state) {
      times[row] = t;
      if (phases != nullptr) phases[row] = piece.phase;
      write_row(states, row, nx, state);
      write_row(inputs, row, nu, plan.trajectory.input_in(piece, t));
      ++row;
    };
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      write(pieces[k], pieces[k].start, pieces[k].state);
      if (ends_phase(k)) write(pieces[k], pieces[k].end(), pieces[k].end_state);
    }
    return SALTUS_OK;
  });
}

}  // extern "C"
