// The exceptions of the framework. They are thrown at set-up only, never during a solve.
#pragma once

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

}  // namespace saltus
