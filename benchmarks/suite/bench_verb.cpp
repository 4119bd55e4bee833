// This file executes `latency` and `answer`. Everything else is Python (suite/scripts), which calls
// the other solvers. The scripts run with the interpreter of the peers' environment, or otherwise
// with that of the system, which finds our solvers only.
#include "benchmarks/suite/bench_verb.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "benchmarks/latency.hpp"
#include "benchmarks/suite/answer.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::array scripted{"list",      "run",   "compare", "report",     "merge",
                              "task",      "peers", "pushes",  "robustness", "map",
                              "reproduce", "fetch", "check"};
constexpr const char* usage =
    "bench latency | list | run | compare | report | merge | pushes | robustness | map | "
    "reproduce | fetch | check | peers [--help]";

constexpr const char* help =
    "compares solvers on the same problems, measures times, runs campaigns\n"
    "Usage: saltus bench VERB ...; VERB --help describes each\n"
    "\n"
    "  latency    solve times of the structured solver on this machine, every solve checked\n"
    "  list       lists problems and solvers, and which packages are missing\n"
    "  run        solves problems with several solvers, checks all answers alike, writes "
    "FILE.jsonl\n"
    "  report     writes FILE.jsonl as an HTML page for offline use\n"
    "  compare    lists improvements and regressions between two such files; status 1 on a "
    "regression\n"
    "  merge      merges the shards of a run into one file\n"
    "  pushes     Monte Carlo of push recovery: random pushes, sensor noise, masses and friction\n"
    "  robustness repeats named experiments of push recovery over seeds: rates with intervals\n"
    "  map        runs every cell of a survival map, in shards\n"
    "  reproduce  repeats the tables of the pages and lists the differences\n"
    "  fetch      copies a public set of problems into the user's cache\n"
    "  check      validates problem files and counts them per class\n"
    "  peers      installs other solvers into a separate Python environment\n";

// `./saltus setup --with-peers` installs next to the program, `saltus bench peers` into the cache.
std::vector<fs::path> peer_folders() {
  std::vector<fs::path> folders{program_folder() / "peers"};
  try {
    folders.push_back(cache_folder() / "peers");
  } catch (const InputError&) {  // without a home folder there is none
  }
  return folders;
}

// The process executes the script.
[[noreturn]] void run_script(std::span<const std::string> arguments) {
  if (const std::string refusal = python_limit_error(); !refusal.empty()) throw InputError(refusal);
  const std::string script = data_file("benchmarks/suite/scripts/bench.py").string();
  const std::vector<fs::path> folders = peer_folders();
  std::vector<std::string> pythons;
  for (const fs::path& folder : folders)
    if (fs::exists(folder / "bin/python3")) pythons.push_back((folder / "bin/python3").string());
  pythons.insert(pythons.end(), {"/usr/bin/python3", "python3"});
  std::error_code unknown;
  setenv("SALTUS_PROGRAM", fs::read_symlink("/proc/self/exe", unknown).c_str(), /*overwrite=*/1);
  setenv("SALTUS_PEERS", folders.back().c_str(), /*overwrite=*/0);
  std::fflush(nullptr);
  for (const std::string& python : pythons) {
    std::vector<std::string> words{python, "-B", script};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execvp(python.c_str(), pointers.data());
  }
  throw InputError("the benchmark suite needs python3");
}

}  // namespace

Verb bench_verb() {
  return {"bench", usage, [](std::span<const std::string> arguments) {
            if (arguments.empty())
              throw InputError(fmt::format("bench needs a command; usage: {}", usage));
            const std::string& what = arguments.front();
            if (what == "--help" || what == "-h") {
              fmt::print("{}", help);
              return ExitStatus::ok;
            }
            if (what == "latency") return verb().run(arguments);
            if (what == "answer") {
              answer_requests(std::cin, std::cout);
              return ExitStatus::ok;
            }
            if (std::find(scripted.begin(), scripted.end(), what) != scripted.end())
              run_script(arguments);
            throw InputError(fmt::format("unknown benchmark '{}'; usage: {}", what, usage));
          }};
}

}  // namespace saltus::bench
