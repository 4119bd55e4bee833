#include "saltus/app/silent_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

namespace saltus {

SilentOutput::SilentOutput() {
  std::fflush(stdout);
  const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nothing < 0) return;
  before_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
  if (before_ >= 0) ::dup2(nothing, STDOUT_FILENO);
  ::close(nothing);
}

SilentOutput::~SilentOutput() {
  std::fflush(stdout);
  if (before_ < 0) return;
  ::dup2(before_, STDOUT_FILENO);
  ::close(before_);
}

}  // namespace saltus
