#include "benchmarks/recorded_sequence.hpp"

#include <fmt/format.h>

#include "benchmarks/data_file.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {

RecordedSequence read_sequence(const std::filesystem::path& file) {
  const nlohmann::json data = read_json(file);
  const auto integer = [&](const nlohmann::json& parent, const char* key) {
    const auto at = parent.is_object() ? parent.find(key) : parent.end();
    if (at == parent.end() || !at->is_number_integer() || *at < 0)
      throw InputError(
          fmt::format("'{}' needs a whole number '{}' of at least 0", file.string(), key));
    return at->get<int>();
  };
  RecordedSequence sequence;
  sequence.intervals = integer(data, "intervals");
  const auto problems = data.find("problems");
  if (problems == data.end() || !problems->is_array() || problems->size() < 2)
    throw InputError(fmt::format("'{}' needs a list 'problems' of at least two", file.string()));
  for (const nlohmann::json& problem : *problems) {
    SequenceProblem& p = sequence.problems.emplace_back();
    p.landing = integer(problem, "landing");
    p.start = vector_of(problem.value("start", nlohmann::json()), 9, file);
  }
  return sequence;
}

}  // namespace saltus::bench
