// Warm starts close to the optimum: Newton's method on the optimality conditions with the active
// set that the given multipliers indicate. This is the primal-dual active set method (Hintermüller,
// Ito and Kunisch, 2002), proximal in the multipliers. Derivation: framework/design/riccati.md.
#pragma once

#include <algorithm>

#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/kkt_system.hpp"

namespace saltus::qp {

/// With the previous multipliers as centre, a side maps the gap G v - beta to the multiplier max(0,
/// centre - weight gap). A soft side at its penalty follows the slope of the penalty instead. For a
/// fixed active set this map is linear: a round is one factorisation and one solve. Convergence is
/// not guaranteed. If the rounds converge, they usually do so within one or two. If the first round
/// changes many sides, the interior-point method is faster. It then starts from the result of that
/// round, which satisfies the dynamics of the current program.
template <KktSystem System>
class ActiveSetRounds {
 public:
  ActiveSetRounds(int variables, int equalities, int sides)
      : weights_(sides),
        centre_(sides),
        gap_(sides),
        moved_(sides),
        first_v_(variables),
        stationarity_(variables),
        step_v_(variables),
        given_y_(equalities),
        equality_(equalities),
        step_y_(equalities),
        given_lambda_(sides) {}

  /// Starts from v, y and lambda of the point, with `values` = G v. Returns true if the rounds
  /// converged with all sides satisfied to the tolerance and `is_optimum()` confirms it. Otherwise
  /// y and lambda are unchanged, and v is that of the first round if there was one. Each round
  /// first checks `stop()`.
  template <class Stop, class Check>
  bool solve(System& system, double tolerance, int most, const AlignedArray& values, Iterate& p,
             const Stop& stop, const Check& is_optimum) {
    remember(system, p);
    const int sides = system.sides();
    std::copy_n(p.lambda.data(), sides, centre_.data());
    std::fill_n(weights_.data(), sides, -1.0);  // a weight that no side can have
    for (int i = 0; i < sides; i += lanes)
      store(&gap_[i], load(&values[i]) - load(system.beta() + i));
    int changes = respond(system, p);
    system.set_shift(0.0);
    int solves = 0;
    for (rounds_ = 0; solves < most_solves && !stop(); ++solves) {
      if (changes > 0 || rounds_ == 0) {
        if (rounds_ == most || !system.factor(weights_.data())) break;
        ++rounds_;
      }
      step(system, p);
      if (solves == 0) std::copy_n(p.v.data(), system.variables(), first_v_.data());
      changes = respond(system, p);
      if (solves == 0 && changes > most_changes) break;
      if (changes > 0) continue;
      if (meets_sides(system, tolerance, p) && is_optimum()) return true;
      // The active set is found. The multipliers absorb the gaps that the finite weight leaves.
      std::copy_n(p.lambda.data(), sides, centre_.data());
      changes = respond(system, p);
    }
    give_back(system, p);
    return false;
  }
  /// Number of factorisations of the last solve().
  int rounds() const { return rounds_; }

 private:
  // In units of the cost per squared unit of the row. If the weight is larger, temporarily
  // contradictory sides get multipliers that later rounds do not correct. If it is smaller, closing
  // the gaps takes more solves. Results are the same from 300 to 3000.
  static constexpr double weight = 1e3;
  static constexpr int most_changes = 5, most_solves = 10;
  // fraction of the tolerance that is allowed for gap x multiplier
  static constexpr double gap_fraction = 0.1;

  void remember(System& system, const Iterate& p) {
    std::copy_n(p.v.data(), system.variables(), first_v_.data());
    std::copy_n(p.y.data(), system.equalities(), given_y_.data());
    std::copy_n(p.lambda.data(), system.sides(), given_lambda_.data());
  }
  void give_back(System& system, Iterate& p) const {
    std::copy_n(first_v_.data(), system.variables(), p.v.data());
    std::copy_n(given_y_.data(), system.equalities(), p.y.data());
    std::copy_n(given_lambda_.data(), system.sides(), p.lambda.data());
  }

  // Computes multipliers and weights for the current gaps. Returns the number of changed weights.
  int respond(System& system, Iterate& p) {
    const Lanes none{}, one = broadcast(1.0), stiff = broadcast(weight);
    Lanes changed{};
    for (int i = 0; i < system.sides(); i += lanes) {
      const Lanes active = load(system.active() + i);
      const Lanes wanted = load(&centre_[i]) - stiff * load(&gap_[i]);
      Lanes lambda = wanted, slope = stiff;
      if (i >= system.first_soft()) {
        const Lanes l1 = load(system.l1() + i), l2 = load(system.l2() + i);
        const Lanes share = l2 / (stiff + l2);
        lambda = wanted > l1 ? l1 + share * (wanted - l1) : wanted;
        slope = wanted > l1 ? share * stiff : stiff;
      }
      lambda = wanted > none ? lambda * active : none;
      slope = wanted > none ? slope * active : none;
      changed += slope != load(&weights_[i]) ? one : none;
      store(&weights_[i], slope);
      store(&p.lambda[i], lambda);
    }
    return static_cast<int>(sum(changed));
  }

  void step(System& system, Iterate& p) {
    system.evaluate(p.v.data(), p.y.data(), p.lambda.data(), stationarity_.data(), equality_.data(),
                    moved_.data());
    system.solve(stationarity_.data(), equality_.data(), step_v_.data(), step_y_.data());
    system.multiply(step_v_.data(), moved_.data());
    add(p.v, step_v_, system.variables());
    add(p.y, step_y_, system.equalities());
    add(gap_, moved_, system.sides());
  }
  static void add(AlignedArray& to, const AlignedArray& step, int size) {
    for (int i = 0; i < size; i += lanes) store(&to[i], load(&to[i]) + load(&step[i]));
  }

  // Checks the violation of hard sides and the products gap x multiplier of active sides.
  bool meets_sides(System& system, double tolerance, const Iterate& p) const {
    Lanes missed{}, worth{};
    for (int i = 0; i < system.sides(); i += lanes) {
      const Lanes gap = load(&gap_[i]) * load(system.active() + i), lambda = load(&p.lambda[i]);
      if (i < system.first_soft()) {
        missed = larger(missed, -gap);
        worth += magnitude(gap) * lambda;
      } else {
        // A soft side with a multiplier between 0 and l1 is active.
        worth += lambda < load(system.l1() + i) ? magnitude(gap) * lambda : Lanes{};
      }
    }
    return largest(missed) <= tolerance && sum(worth) <= gap_fraction * tolerance;
  }

  AlignedArray weights_, centre_, gap_, moved_;
  AlignedArray first_v_, stationarity_, step_v_, given_y_, equality_, step_y_, given_lambda_;
  int rounds_ = 0;
};

}  // namespace saltus::qp
