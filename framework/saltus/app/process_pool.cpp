#include "saltus/app/process_pool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "saltus/core/error.hpp"
#include "saltus/core/write_all.hpp"

namespace saltus {
namespace {

// A child writes one of these marks and then the result as its last output. Marks contain control
// characters, which no library prints.
constexpr std::string_view done_mark = "\x01done\x02";
constexpr std::string_view refused_mark = "\x01refused\x02";
constexpr std::string_view threw_mark = "\x01threw\x02";
constexpr std::string_view end_mark = "\x03";  // marks a complete result

// Body of a child process.
[[noreturn]] void serve(int pipe, const std::function<std::string()>& work) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // children die with the parent
#endif
  // An interrupt from the keyboard reaches the whole process group; only the parent handles it.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
  ::dup2(pipe, STDOUT_FILENO);
  ::dup2(pipe, STDERR_FILENO);
  std::string result;
  const auto tell = [&](std::string_view mark, std::string_view text) {
    result.append(mark).append(text).append(end_mark);
  };
  try {
    const std::string text = work();
    tell(done_mark, text);
  } catch (const InputError& error) {
    tell(refused_mark, error.what());
  } catch (const DefinitionError& error) {
    tell(refused_mark, error.what());
  } catch (const std::exception& error) {
    tell(threw_mark, error.what());
  } catch (...) {
    tell(threw_mark, "an unknown exception");
  }
  std::fflush(nullptr);
  write_all(pipe, result);
  ::_exit(0);  // skips destructors of the parent's objects
}

// Extracts the text between the mark and the end mark, if the output ends with it.
bool take(std::string_view output, std::string_view mark, std::string& text) {
  if (!output.ends_with(end_mark)) return false;
  const std::size_t at = output.rfind(mark);
  if (at == std::string_view::npos) return false;
  output.remove_suffix(end_mark.size());
  text = output.substr(at + mark.size());
  return true;
}

std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.find_last_of('\n') + 1);
}

}  // namespace

ProcessPool::ProcessPool(int jobs, double time_limit) : jobs_(jobs), time_limit_(time_limit) {
  if (jobs < 1)
    throw DefinitionError(fmt::format("a process pool needs at least one job, not {}", jobs));
  if (!(time_limit > 0.0))
    throw DefinitionError(fmt::format("the time limit of a process pool is {} s", time_limit));
}

ProcessPool::~ProcessPool() { stop(); }

void ProcessPool::start(long id, const std::function<std::string()>& work) {
  if (is_full()) throw DefinitionError(fmt::format("all {} processes are busy", jobs_));
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw std::system_error(errno, std::generic_category(),
                            "cannot create a pipe for another process");
  std::fflush(nullptr);  // otherwise the child would print it again
  const pid_t process = ::fork();
  if (process == 0) {
    ::close(ends[0]);
    for (const Child& other : running_) ::close(other.pipe);
    serve(ends[1], work);
  }
  const int error = errno;
  ::close(ends[1]);
  if (process < 0) {
    ::close(ends[0]);
    throw std::system_error(error, std::generic_category(), "cannot start another process");
  }
  running_.push_back({id, process, ends[0], {}, WallClock::now(), false});
}

std::vector<WorkResult> ProcessPool::wait(double seconds) {
  // Adds 1 ms, so that poll() does not return just before the limit.
  const double patience = std::min(seconds, end_overdue() + 1e-3);
  std::vector<pollfd> files;
  for (const Child& child : running_) files.push_back({child.pipe, POLLIN, 0});
  std::vector<WorkResult> finished;
  if (::poll(files.data(), files.size(), static_cast<int>(1e3 * patience)) <= 0) return finished;
  std::vector<Child> still;
  for (std::size_t i = 0; i < running_.size(); ++i) {
    Child& child = running_[i];
    bool ended = false;
    if (files[i].revents != 0) {
      char buffer[4096];
      const ssize_t n = ::read(child.pipe, buffer, sizeof buffer);
      if (n > 0) child.output.append(buffer, static_cast<std::size_t>(n));
      ended = n == 0 || (n < 0 && errno != EINTR);
    }
    if (ended)
      finished.push_back(collect(child));
    else
      still.push_back(std::move(child));
  }
  running_ = std::move(still);
  return finished;
}

double ProcessPool::end_overdue() {
  double left = time_limit_;
  for (Child& child : running_) {
    const double age = seconds_since(child.begin);
    if (age >= time_limit_) {
      child.overdue = true;
      ::kill(child.process, SIGKILL);  // its pipe closes, and wait() collects it
    } else {
      left = std::min(left, time_limit_ - age);
    }
  }
  return left;
}

WorkResult ProcessPool::collect(Child& child) const {
  using End = WorkResult::End;
  ::close(child.pipe);
  int status = 0;
  while (::waitpid(child.process, &status, 0) < 0 && errno == EINTR) {
  }
  WorkResult work{child.id, End::died, {}};
  if (take(child.output, done_mark, work.text)) {
    work.end = End::done;
  } else if (take(child.output, refused_mark, work.text)) {
    work.end = End::refused;
  } else if (take(child.output, threw_mark, work.text)) {
    work.text = "it threw: " + work.text;
  } else {
    work.text = child.overdue         ? fmt::format("it took longer than {} s", time_limit_)
                : WIFSIGNALED(status) ? fmt::format("it crashed ({})", strsignal(WTERMSIG(status)))
                                      : fmt::format("it exited with {}", WEXITSTATUS(status));
    const std::string words = last_line(child.output);
    if (!words.empty()) work.text += ": " + words;
  }
  return work;
}

void ProcessPool::stop() {
  for (const Child& child : running_) ::kill(child.process, SIGKILL);
  for (Child& child : running_) collect(child);
  running_.clear();
}

}  // namespace saltus
