#include "saltus/app/process_limits.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>

#include "saltus/app/program.hpp"
#include "saltus/core/write_all.hpp"

namespace saltus {
namespace {

[[noreturn]] void end_without_handler() {
  std::string_view sentence;
  if (const std::exception_ptr thrown = std::current_exception()) {
    try {
      std::rethrow_exception(thrown);
    } catch (const std::bad_alloc&) {
      sentence = "saltus: not enough memory; a smaller problem needs less\n";
    } catch (const std::system_error&) {
      sentence = "saltus: the system denies a thread, a process or a file; raise its limits\n";
    } catch (...) {
    }
  }
  if (sentence.empty()) std::abort();
  write_all(STDERR_FILENO, sentence);
  ::_exit(static_cast<int>(ExitStatus::bad_input));
}

}  // namespace

void prepare_process() {
  std::signal(SIGXFSZ, SIG_IGN);
  sigset_t interrupts;
  ::sigemptyset(&interrupts);
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, SIG_DFL);
    ::sigaddset(&interrupts, signal);
  }
  ::sigprocmask(SIG_UNBLOCK, &interrupts, nullptr);
  std::set_terminate(end_without_handler);
}

#ifdef __linux__
namespace {

constexpr const char* one_thread = "OPENBLAS_NUM_THREADS=1";
constexpr std::size_t name_length = std::string_view("OPENBLAS_NUM_THREADS=").size();

bool is_below(int resource, rlim_t enough) {
  rlimit limit{};
  return ::getrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0 &&
         limit.rlim_cur < enough;
}

// Runs before the initialisers of shared libraries, so neither their functions nor the environment
// nor the heap can be used.
__attribute__((no_sanitize("address", "undefined", "thread"))) void start_with_one_thread(
    int, char** argv, char** env) {
  if (!is_below(RLIMIT_AS, RLIM_INFINITY) && !is_below(RLIMIT_DATA, RLIM_INFINITY) &&
      !is_below(RLIMIT_NPROC, 1024))
    return;
  constexpr int most = 4096;
  const char* limited[most];
  int count = 0;
  for (; env[count] != nullptr; ++count) {
    if (count > most - 3 || std::strncmp(env[count], one_thread, name_length) == 0) return;
    limited[count] = env[count];
  }
  limited[count++] = one_thread;
  limited[count] = nullptr;
  // on failure the program continues
  ::execve("/proc/self/exe", argv, const_cast<char* const*>(limited));
}

using Initialiser = void (*)(int, char**, char**);
[[gnu::section(".preinit_array"), gnu::used]] const Initialiser before_libraries =
    start_with_one_thread;

}  // namespace
#endif

}  // namespace saltus
