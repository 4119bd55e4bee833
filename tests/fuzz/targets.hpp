// The readers of what comes from outside, each as a function of bytes: what the fuzzer calls
// (fuzzer.cpp), and what the tests call with every input that is kept (readers_test.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace saltus::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A reader. Reading either succeeds or throws InputError with one sentence; anything else (another
/// exception, a sentence of pages, an invariant that does not hold) ends the
/// process by std::abort() after a line on the error stream.
struct Target {
  std::string name;                  ///< also that of its folder in corpus/
  std::function<void(Bytes)> read;   ///< may throw InputError
  std::vector<std::string> words{};  ///< that random bytes would hardly hit upon
};

const std::vector<Target>& targets();
/// Throws InputError that names them all.
const Target& target(const std::string& name);

/// Lets the target read and judges how it ended, see Target.
void run(const Target& target, Bytes bytes);

/// A folder of this process alone, in memory where there is such a place; gone at exit.
const std::filesystem::path& own_folder();
/// A file in own_folder() with these bytes, for readers that take a path: each input writes over
/// the one before.
std::filesystem::path file_with(Bytes bytes, const std::string& name);

/// Ends the process unless `holds`; for what must be true of what a reader took.
void require(bool holds, const std::string& what);

}  // namespace saltus::fuzz
