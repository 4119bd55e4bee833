#include "saltus/core/isolated_call.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "saltus/core/write_all.hpp"

namespace saltus {
namespace {

constexpr double memory_limit = 4e9;  // bytes
constexpr char whole = '\x03';        // last byte of complete output

// Data segment of this process in bytes. Unlimited with a sanitizer.
double data_in_use() {
  double size = 0.0, pages = 0.0;
  std::ifstream statm("/proc/self/statm");
  for (int i = 0; i < 5; ++i) statm >> size;
  statm >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

// Runs the child process: no output, no core dumps.
[[noreturn]] void serve(int pipe, const std::function<std::string()>& work, int seconds) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTERM, SIGPIPE, SIGALRM})
    std::signal(signal, SIG_DFL);
  const rlim_t most = static_cast<rlim_t>(seconds);
  const rlimit time{most, most}, core{0, 0};
  ::setrlimit(RLIMIT_CPU, &time);
  ::setrlimit(RLIMIT_CORE, &core);
  ::alarm(10U * static_cast<unsigned>(seconds) + 10U);  // also ends endless waiting
  const double data = data_in_use() + memory_limit;
  const rlimit memory{static_cast<rlim_t>(data), static_cast<rlim_t>(data)};
  if (data < 4.0 * memory_limit) ::setrlimit(RLIMIT_DATA, &memory);
  try {
    write_all(pipe, work() + whole);
  } catch (...) {  // the parent detects missing output
  }
  ::_exit(0);  // no destructors of the parent's objects
}

}  // namespace

std::optional<std::string> isolated_call(const std::function<std::string()>& work, int seconds) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return std::nullopt;
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    serve(ends[1], work, seconds);
  }
  ::close(ends[1]);
  std::string text;
  std::array<char, 1U << 16U> piece{};
  for (ssize_t n = 1; child > 0 && n != 0;) {
    n = ::read(ends[0], piece.data(), piece.size());
    if (n < 0 && errno != EINTR) break;
    if (n > 0) text.append(piece.data(), static_cast<std::size_t>(n));
  }
  ::close(ends[0]);
  int status = 0;
  while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (text.empty() || text.back() != whole) return std::nullopt;
  text.pop_back();
  return text;
}

}  // namespace saltus
