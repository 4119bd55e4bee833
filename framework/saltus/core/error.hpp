// The exceptions of the framework: thrown at set-up only, never while a solve runs.
#pragma once

#include <stdexcept>
#include <string>

namespace saltus {

/// A problem, phase, term or option is defined wrongly. The message names it, what was expected
/// and what was given.
class DefinitionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A file, key or value that came from outside is unusable. The message is one sentence that names
/// where it stands and the remedy. Programs end with exit status 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace saltus
