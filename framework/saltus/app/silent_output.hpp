// Nothing on the standard output for a while, of this process and of those that it starts.
#pragma once

namespace saltus {

/// While it lives, what is printed is lost; errors are not. One at a time.
class SilentOutput {
 public:
  SilentOutput();
  ~SilentOutput();
  SilentOutput(const SilentOutput&) = delete;
  SilentOutput& operator=(const SilentOutput&) = delete;

 private:
  int before_ = -1;  // descriptor; -1: it could not be put aside
};

}  // namespace saltus
