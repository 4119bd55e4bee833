// Suppresses the standard output of this process and its children for a scope.
#pragma once

namespace saltus {

/// Discards the standard output while it lives; the error stream is not affected. Only one object
/// may live at a time.
class SilentOutput {
 public:
  SilentOutput();
  ~SilentOutput();
  SilentOutput(const SilentOutput&) = delete;
  SilentOutput& operator=(const SilentOutput&) = delete;

 private:
  int before_ = -1;  // descriptor; -1: the output could not be redirected
};

}  // namespace saltus
