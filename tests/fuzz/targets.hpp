// The readers of external data, each as a function of bytes. The fuzzer (fuzzer.cpp) calls them,
// and the tests call them with every stored input (readers_test.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace saltus::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A reader. Reading either succeeds or throws InputError with one sentence. Anything else (another
/// exception, an overlong message, a broken invariant) ends the process by std::abort() after a
/// line on the error stream.
struct Target {
  std::string name;                  ///< also the name of its folder in corpus/
  std::function<void(Bytes)> read;   ///< may throw InputError
  std::vector<std::string> words{};  ///< words that random bytes rarely contain
};

const std::vector<Target>& targets();
/// Throws InputError with all names if the name is unknown.
const Target& target(const std::string& name);

/// Runs the reader and checks how it ends; see Target.
void run(const Target& target, Bytes bytes);

/// A folder that only this process uses, in memory if possible. It is deleted at exit.
const std::filesystem::path& own_folder();
/// A file in own_folder() with these bytes, for readers that take a path. Each input overwrites the
/// previous one.
std::filesystem::path file_with(Bytes bytes, const std::string& name);

/// Ends the process unless `holds`. It checks the invariants of accepted inputs.
void require(bool holds, const std::string& what);

}  // namespace saltus::fuzz
