// libFuzzer's entry points: `saltus_fuzz --reader=NAME [options of libFuzzer] [FOLDER...]`. With
// --readers it prints the names, with --words=NAME the dictionary of the reader.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "tests/fuzz/targets.hpp"

namespace {
const saltus::fuzz::Target* chosen = nullptr;

// s of processor time, since the machine may be busy. Sanitizers make readers several times slower.
constexpr double longest_time = 1.0;
double slowest = 0.0;  // s

double processor_time() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void print_in_all() {
  fmt::print(stderr, "in all: {:.0f} s of processor time, the slowest input {:.0f} ms\n",
             processor_time(), 1e3 * slowest);
}

void print_dictionary(const saltus::fuzz::Target& target) {
  for (const std::string& word : target.words) {
    fmt::print("\"");
    for (const unsigned char c : word) fmt::print("\\x{:02x}", c);
    fmt::print("\"\n");
  }
}
}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) try {
  for (int i = 1; i < *argc; ++i) {
    const std::string_view word = (*argv)[i];
    if (word == "--readers") {
      for (const saltus::fuzz::Target& target : saltus::fuzz::targets())
        fmt::print("{}\n", target.name);
      std::exit(0);
    }
    if (word.starts_with("--words=")) {
      print_dictionary(saltus::fuzz::target(std::string(word.substr(8))));
      std::exit(0);
    }
    if (word.starts_with("--reader=")) chosen = &saltus::fuzz::target(std::string(word.substr(9)));
  }
  if (chosen == nullptr) {
    fmt::print(stderr, "saltus_fuzz: give --reader=NAME; --readers lists them\n");
    std::exit(2);
  }
  std::atexit(print_in_all);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "saltus_fuzz: {}\n", error.what());
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const double begin = processor_time();
  saltus::fuzz::run(*chosen, {data, size});
  const double taken = processor_time() - begin;
  slowest = std::max(slowest, taken);
  saltus::fuzz::require(taken < longest_time, "an input took more than a second");
  return 0;
}
