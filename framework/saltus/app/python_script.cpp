#include "saltus/app/python_script.hpp"

#include <fmt/format.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"

namespace saltus {
namespace {

constexpr int script_has_said_why = 3;  // python/saltus/drawing.py
constexpr int files_not_written = 4;    // python/saltus/on_folder.py has printed a message

// Runs python3 -B WORD... Our package has priority over any other package of its name, and the
// current folder is not in the search path. Returns the exit status, or -1 if there is none.
int status_of_python(std::vector<std::string> words, const std::string& package) {
  const char* before = std::getenv("PYTHONPATH");
  const std::string path =
      before == nullptr || *before == '\0' ? package : fmt::format("{}:{}", package, before);
  words.insert(words.begin(), {"python3", "-B"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
#ifdef __linux__
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends with its parent
#endif
    std::signal(SIGINT, SIG_DFL);
    setenv("OPENBLAS_NUM_THREADS", "1", 0);  // for numpy: one thread suffices for plots
    setenv("PYTHONPATH", path.c_str(), 1);
    setenv("PYTHONSAFEPATH", "1", 1);
    // Prefers the system's python3, whose packages the set-up installs. Python finds its
    // environment by the name in arguments[0].
    const char* named = std::getenv("SALTUS_PYTHON");
    const bool is_named = named != nullptr && *named != '\0';
    for (const char* python :
         {is_named ? named : "/usr/bin/python3", is_named ? named : "python3"}) {
      arguments[0] = const_cast<char*>(python);
      execvp(python, arguments.data());
    }
    _exit(127);
  }
  int status = 0;
  pid_t ended = -1;
  while (child > 0 && (ended = waitpid(child, &status, 0)) < 0 && errno == EINTR) {
  }
  return ended > 0 && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// `make_words` receives the folder of the package; the last word that it returns is the module or
// script.
template <class MakeWords>
bool run_python(MakeWords make_words, const std::filesystem::path& results, std::string_view what,
                std::span<const std::string> more) {
  if (const std::string refusal = python_limit_error(); !refusal.empty()) {
    fmt::print(stderr, "no {}: {}\n", what, refusal);
    return false;
  }
  std::vector<std::string> words;
  std::string package;
  try {
    package = data_file("python").string();
    words = make_words();
  } catch (const InputError& error) {
    fmt::print(stderr, "no {}: {}\n", what, error.what());
    return false;
  }
  const std::string shown = words.back();
  words.push_back(results.string());
  words.insert(words.end(), more.begin(), more.end());
  const int status = status_of_python(std::move(words), package);
  if (status == files_not_written)
    throw InputError(
        fmt::format("no {}: the files cannot be written into '{}'", what, results.string()));
  if (status != 0 && status != script_has_said_why)
    fmt::print(stderr, "no {}: python3 could not run {}\n", what, shown);
  return status == 0;
}

}  // namespace

std::string python_limit_error() {
  constexpr rlim_t least_memory = rlim_t{512} << 20U;  // bytes; plots need about half of it
  constexpr rlim_t least_files = 16;
  rlimit limit{};
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    if (::getrlimit(resource, &limit) == 0 && limit.rlim_cur < least_memory) {
      return fmt::format("python3 needs {} MB of memory, and the limit is {} MB (ulimit -{})",
                         least_memory >> 20U, limit.rlim_cur >> 20U,
                         resource == RLIMIT_AS ? 'v' : 'd');
    }
  }
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < least_files) {
    return fmt::format("python3 needs {} open files, and the limit is {} (ulimit -n)", least_files,
                       limit.rlim_cur);
  }
  return {};
}

bool run_python_module(std::string_view module, const std::filesystem::path& results,
                       std::string_view what, std::span<const std::string> more) {
  const auto words = [module] { return std::vector<std::string>{"-m", std::string(module)}; };
  return run_python(words, results, what, more);
}

bool run_python_script(std::string_view script, const std::filesystem::path& results,
                       std::string_view what) {
  const auto words = [script] {
    return std::vector<std::string>{data_file(std::string(script)).string()};
  };
  return run_python(words, results, what, {});
}

}  // namespace saltus
