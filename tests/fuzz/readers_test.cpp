// Runs every stored input: seeds and inputs found by the fuzzer. A reader that ends in a forbidden
// way ends this process, and ctest shows the input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "tests/fuzz/targets.hpp"

namespace saltus::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Stored inputs of a reader, sorted, for the same order on every machine. The configuration of iCub
// is one of those of robot_file.
std::set<fs::path> inputs_of(const std::string& reader) {
  const fs::path corpus = SALTUS_FUZZ_CORPUS;
  std::set<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(corpus / reader))
    files.insert(entry.path());
  if (reader == "robot_file") files.insert(corpus / "../../../robots/icub/icub.yaml");
  return files;
}

// Stored before the call, so that the last input survives a crash of the process.
void keep(const std::vector<std::uint8_t>& bytes) {
  std::ofstream("fuzz_last_input", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

class Readers : public testing::TestWithParam<std::string> {};

TEST_P(Readers, HandleStoredInputs) {
  const std::set<fs::path> files = inputs_of(GetParam());
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    std::fprintf(stderr, "%s\n", file.filename().c_str());
    run(target(GetParam()), content_of(file));
  }
  EXPECT_GT(files.size(), 1u);
}

// Inputs cut off at any position, and inputs with each byte changed. Every reader accepts some
// inputs.
TEST_P(Readers, HandleTruncatedAndCorruptInputs) {
  const Target& reader = target(GetParam());
  for (const fs::path& file : inputs_of(GetParam())) {
    const std::vector<std::uint8_t> whole = content_of(file);
    if (whole.size() > 4000) continue;
    const std::size_t stride = std::max<std::size_t>(1, whole.size() / 50);
    for (std::size_t at = 0; at < whole.size(); at += stride) {
      run(reader, Bytes(whole).first(at));
      std::vector<std::uint8_t> spoilt = whole;
      spoilt[at] ^= 0x15;
      run(reader, spoilt);
    }
  }
}

// A name that is pages long, at any position. The message shows its beginning only.
TEST_P(Readers, HandleNamesOfPages) {
  const Target& reader = target(GetParam());
  for (const fs::path& file : inputs_of(GetParam())) {
    const std::vector<std::uint8_t> whole = content_of(file);
    if (whole.size() > 10000) continue;
    const std::size_t stride = std::max<std::size_t>(1, whole.size() / 100);
    for (std::size_t at = 0; at < whole.size(); at += stride) {
      std::vector<std::uint8_t> longer = whole;
      longer.insert(longer.begin() + static_cast<std::ptrdiff_t>(at), 3000, 'e');
      run(reader, longer);
    }
  }
}

// Random combinations of stored inputs and dictionary words, like a fuzzer without branch coverage.
// Runs on every platform in a second.
TEST_P(Readers, HandleRandomCombinations) {
  constexpr unsigned seed = 1;
  const char* more = std::getenv("SALTUS_FUZZ_ROUNDS");  // set by hand for more rounds
  const int rounds = more == nullptr ? 300 : std::atoi(more);
  std::fprintf(stderr, "seed %u\n", seed);
  const Target& reader = target(GetParam());
  std::vector<std::vector<std::uint8_t>> kept;
  for (const fs::path& file : inputs_of(GetParam())) kept.push_back(content_of(file));
  std::mt19937 random(seed);
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> bytes = kept[below(kept.size())];
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      const std::size_t at = below(bytes.size() + 1);
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      const auto until = begin + static_cast<std::ptrdiff_t>(below(bytes.size() - at + 1));
      const std::vector<std::uint8_t>& other = kept[below(kept.size())];
      const std::size_t from = below(other.size());
      const std::string& word = reader.words[below(reader.words.size())];
      switch (below(5)) {
        case 0:
          bytes.insert(begin, word.begin(), word.end());
          break;
        case 1:
          bytes.erase(begin, until);
          break;
        case 2:
          bytes.insert(begin, other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
          break;
        case 3:
          if (at < bytes.size()) bytes[at] = static_cast<std::uint8_t>(random());
          break;
        default:
          bytes.insert(begin, 1 + below(6), static_cast<std::uint8_t>('0' + below(10)));
      }
    }
    if (bytes.size() > 20000) bytes.resize(20000);
    if (more != nullptr) keep(bytes);
    run(reader, bytes);
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Target& one : targets()) all.push_back(one.name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, Readers, testing::ValuesIn(names()),
                         [](const auto& reader) { return reader.param; });

}  // namespace
}  // namespace saltus::fuzz
