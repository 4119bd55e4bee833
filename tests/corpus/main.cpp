// The adversarial corpus: random problems of kinds for which solvers often give a wrong answer
// without a warning, checked by an independent judge.
//
//     saltus_corpus                          the full set, seeds from 1 on
//     saltus_corpus --gate                   the sample of the gate
//     saltus_corpus --class pillars --seed 17 [--solver riccati]
//
// Exits with status 1 if any answer is silently wrong, or if more than 0.5 % of the right answers
// are refused.
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "saltus/core/clock.hpp"
#include "tests/corpus/trial.hpp"

namespace {

using namespace saltus;
using namespace saltus::corpus;

struct Request {
  std::string family;
  std::optional<std::uint64_t> seed;
  std::uint64_t base = 1;
  std::optional<SolverChoice> solver;
  int trials = 0;
  bool gate = false, verbose = false;
};

[[noreturn]] void usage(const std::string& why) {
  fmt::print(stderr,
             "{}\nsaltus_corpus [--gate] [--class NAME] [--seed S | --base S] [--trials N] "
             "[--solver ipopt|sparse|riccati] [--verbose]\n",
             why);
  std::exit(2);
}

Request read(int argc, char** argv) {
  Request request;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) usage(name + " needs a value");
      return argv[++i];
    };
    if (name == "--gate")
      request.gate = true;
    else if (name == "--verbose")
      request.verbose = true;
    else if (name == "--class")
      request.family = value();
    else if (name == "--seed")
      request.seed = std::strtoull(value().c_str(), nullptr, 10);
    else if (name == "--base")
      request.base = std::strtoull(value().c_str(), nullptr, 10);
    else if (name == "--trials")
      request.trials = std::atoi(value().c_str());
    else if (name == "--solver") {
      const std::string wanted = value();
      for (const auto& [word, choice] : solver_choices())
        if (word == wanted) request.solver = choice;
      if (!request.solver) usage("there is no solver '" + wanted + "'");
    } else
      usage("there is no option '" + name + "'");
  }
  return request;
}

const char* word_for(Outcome outcome) {
  constexpr const char* words[] = {"right",      "reported", "WRONG",
                                   "unreported", "refused",  "unsolved"};
  return words[static_cast<int>(outcome)];
}

struct Count {
  std::array<int, 6> of{};
  int total() const {
    int sum = 0;
    for (const int n : of) sum += n;
    return sum;
  }
  int operator[](Outcome outcome) const { return of[static_cast<int>(outcome)]; }
};

void print_row(const char* name, const Count& count, double seconds, const char* ranges) {
  fmt::print("{:<18}{:>7}{:>7}{:>10}{:>7}{:>12}{:>9}{:>10}{:>8.1f}  {}\n", name, count.total(),
             count[Outcome::right], count[Outcome::reported], count[Outcome::wrong],
             count[Outcome::unreported], count[Outcome::refused], count[Outcome::unsolved], seconds,
             ranges);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const Request request = read(argc, argv);
  fmt::print("{:<18}{:>7}{:>7}{:>10}{:>7}{:>12}{:>9}{:>10}{:>8}  {}\n", "class", "trials", "right",
             "reported", "WRONG", "unreported", "refused", "unsolved", "s", "drawn");
  Count all;
  double seconds = 0.0;
  std::string listed;
  bool found = false;
  int imprecise = 0;
  for (const CorpusClass& family : corpus_classes()) {
    if (!request.family.empty() && request.family != family.name) continue;
    found = true;
    const int trials = request.seed         ? 1
                       : request.trials > 0 ? request.trials
                       : request.gate       ? family.gate
                                            : family.full;
    Count count;
    const auto start = WallClock::now();
    for (int k = 0; k < trials; ++k) {
      const std::uint64_t seed = request.seed.value_or(request.base + k);
      const Verdict verdict = run_trial(family, seed, request.solver);
      ++count.of[static_cast<int>(verdict.outcome)];
      imprecise += verdict.is_imprecise ? 1 : 0;
      const bool notable =
          verdict.outcome != Outcome::right && verdict.outcome != Outcome::reported;
      if (notable || request.verbose || request.seed) {
        listed += fmt::format("{:<9} --class {} --seed {}: {}\n", word_for(verdict.outcome),
                              family.name, seed, verdict.reason);
      }
    }
    const double taken = seconds_since(start);
    print_row(family.name, count, taken, family.ranges);
    seconds += taken;
    for (std::size_t i = 0; i < all.of.size(); ++i) all.of[i] += count.of[i];
  }
  if (!found) usage("there is no class '" + request.family + "'");
  print_row("all", all, seconds, "");
  if (!listed.empty()) fmt::print("\n{}", listed);
  fmt::print(
      "\nright, with end errors above 1e-6 of the size but within the stated accuracy of the "
      "integration: {}",
      imprecise);
  fmt::print("\nsilent wrong answers: {} of {}; right answers refused: {} ({:.2f} %)\n",
             all[Outcome::wrong], all.total(), all[Outcome::refused],
             100.0 * all[Outcome::refused] / std::max(1, all.total()));
  return all[Outcome::wrong] == 0 && all[Outcome::refused] <= std::max(1.0, 0.005 * all.total())
             ? 0
             : 1;
}
