#include "benchmarks/hanging_chain.hpp"

#include "benchmarks/data_file.hpp"

namespace saltus::bench {

ChainData read_chain(const std::filesystem::path& file) {
  const nlohmann::json data = read_json(file);
  const auto state = [&](const char* key) {
    const auto at = data.is_object() ? data.find(key) : data.end();
    return vector_of(at == data.end() ? nlohmann::json() : *at, HangingChain::nx, file);
  };
  ChainData chain;
  chain.reference = state("reference");
  chain.start = state("start");
  return chain;
}

}  // namespace saltus::bench
