// The exceptions of the framework. They are thrown at set-up only, never during a solve.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace saltus {

/// A problem, phase, term or option is defined incorrectly. The message names it, the expected
/// value and the given value.
class DefinitionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A file, key or value from outside the program is unusable. The message names its place and the
/// remedy in one sentence. Programs end with exit status 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The message of an exception of unknown type.

/// Message of the exception being handled. Call it only inside a catch block.
inline std::string describe_exception() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an exception that is not a std::exception";
  }
}

}  // namespace saltus
