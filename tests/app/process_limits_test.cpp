// Tests signals and system limits: how a process ends and with which message.
#include "saltus/app/process_limits.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <string>
#include <system_error>
#include <thread>

#include "saltus/app/defer_signals.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/thread_pool.hpp"
#include "tests/support/sanitized.hpp"

namespace saltus {
namespace {

constexpr unsigned patience = 10;  // s, timeout after which a hanging child is killed

struct End {
  int status = 0;
  std::string error;  // text on the error stream
};

// Runs `work` in a child process and returns how the child ends.
End end_of(const std::function<void()>& work) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(patience);
    ::dup2(ends[1], STDERR_FILENO);
    work();
    ::_exit(0);
  }
  ::close(ends[1]);
  End end;
  char piece[256];
  for (ssize_t n = 0; (n = ::read(ends[0], piece, sizeof piece)) > 0;)
    end.error.append(piece, static_cast<std::size_t>(n));
  ::close(ends[0]);
  EXPECT_EQ(::waitpid(child, &end.status, 0), child);
  return end;
}

TEST(DeferSignals, TheSecondSignalOfEitherKindEndsTheProcess) {
  for (const int first : {SIGINT, SIGTERM}) {
    for (const int second : {SIGINT, SIGTERM}) {
      const End end = end_of([&] {
        const DeferSignals note;
        std::raise(first);
        if (DeferSignals::received() != first) ::_exit(1);
        std::raise(second);
      });
      ASSERT_TRUE(WIFSIGNALED(end.status)) << first << ", " << second << ": " << end.status;
      EXPECT_EQ(WTERMSIG(end.status), second);
    }
  }
}

TEST(DeferSignals, TwoSignalsThatArriveAtOnceEndTheProcess) {
  const End end = end_of([] {
    const DeferSignals note;
    sigset_t both;
    ::sigemptyset(&both);
    ::sigaddset(&both, SIGINT);
    ::sigaddset(&both, SIGTERM);
    ::sigprocmask(SIG_BLOCK, &both, nullptr);
    std::raise(SIGINT);
    std::raise(SIGTERM);
    ::sigprocmask(SIG_UNBLOCK, &both, nullptr);
  });
  EXPECT_TRUE(WIFSIGNALED(end.status)) << end.status;
}

TEST(ProcessLimits, InterruptsWorkIfTheCallerIgnoredOrBlockedThem) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const End end = end_of([&] {
      std::signal(signal, SIG_IGN);
      sigset_t all;
      ::sigfillset(&all);
      ::sigprocmask(SIG_BLOCK, &all, nullptr);
      prepare_process();
      std::raise(signal);
    });
    ASSERT_TRUE(WIFSIGNALED(end.status)) << signal;
    EXPECT_EQ(WTERMSIG(end.status), signal);
  }
}

TEST(ProcessLimits, FileSizeLimitIsAWriteError) {
  const End end = end_of([] {
    std::signal(SIGXFSZ, SIG_DFL);
    prepare_process();
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_FSIZE, &none);
    char name[] = "/tmp/saltus-limit-XXXXXX";
    const int file = ::mkstemp(name);
    ::unlink(name);
    ::_exit(::write(file, "x", 1) < 0 && errno == EFBIG ? 3 : 4);
  });
  ASSERT_TRUE(WIFEXITED(end.status)) << end.status;
  EXPECT_EQ(WEXITSTATUS(end.status), 3);
}

TEST(ProcessLimits, OutOfMemoryInAThreadGivesASentence) {
  const End end = end_of([] {
    prepare_process();
    std::jthread([] { throw std::bad_alloc(); }).join();
  });
  ASSERT_TRUE(WIFEXITED(end.status)) << end.status;
  EXPECT_EQ(WEXITSTATUS(end.status), 2);
  EXPECT_EQ(end.error, "saltus: not enough memory; a smaller problem needs less\n");
}

TEST(ProcessLimits, TooLittleMemoryForPythonGivesASentence) {
  if (test::sanitized) GTEST_SKIP() << "sanitizers need more address space";
  EXPECT_EQ(python_limit_error(), "");
  const End end = end_of([] {
    const rlimit files{8, 8};
    ::setrlimit(RLIMIT_NOFILE, &files);
    std::fputs(python_limit_error().c_str(), stderr);
    const rlimit addresses{std::size_t{300} << 20U, std::size_t{300} << 20U};
    ::setrlimit(RLIMIT_AS, &addresses);
    std::fputs(("; " + python_limit_error()).c_str(), stderr);
  });
  EXPECT_EQ(end.error,
            "python3 needs 16 open files, and the limit is 8 (ulimit -n); python3 needs 512 MB of "
            "memory, and the limit is 300 MB (ulimit -v)");
}

// There is no memory for the stack of another thread. A limit on the number of threads has the same
// effect.
TEST(ThreadPool, ThrowsIfThreadsCannotStart) {
  if (test::sanitized) GTEST_SKIP() << "sanitizers need more address space";
  const End end = end_of([] {
    const rlimit addresses{std::size_t{1} << 29U, std::size_t{1} << 29U};
    ::setrlimit(RLIMIT_AS, &addresses);
    try {
      const ThreadPool pool(200);  // 8 MB of stack each
    } catch (const std::system_error&) {
      ::_exit(5);
    }
  });
  ASSERT_TRUE(WIFEXITED(end.status)) << "it waits for ever: " << end.status;
  EXPECT_EQ(WEXITSTATUS(end.status), 5);
}

}  // namespace
}  // namespace saltus
