// A heat pump keeps an office warm during opening hours; energy is cheap at other times. The
// controller has a horizon of twelve hours across these events and heats before the doors open. On
// the first evening the opening time of the second day moves two hours ahead.
#include <cstdio>
#include <fstream>
#include <saltus/saltus.hpp>

using namespace saltus;

template <class S>
struct House {
  S losses = 0.12;   // heat loss of the air to the outside, 1/h
  S exchange = 0.6;  // between air and walls, 1/h
  S outside = 2.0;   // degrees Celsius

  using Entries = ParameterEntries<&House::losses, &House::exchange, &House::outside>;
};

struct Warmth {  // x = (air, walls) in degrees Celsius, u = heat in kW; time in hours
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, size_of<House>>& p) const {
    const auto house = view_as<House>(p);
    const S flow = house.exchange * (x[0] - x[1]);
    return {2.0 * u[0] - flow - house.losses * (x[0] - house.outside), 0.15 * flow};
  }
};

int main() {
  constexpr double period = 0.25, horizon = 12.0;  // h
  const auto air = [](auto, auto x) { return x[0]; };
  const auto heat = [](auto, auto, auto u) { return u[0]; };

  Phase<2, 1, size_of<House>> phase{"office", Warmth{}, exactly(horizon)};
  phase.bound_input(0, between(0.0, 4.0))
      .keep("comfort", air, between(20.0, 23.0), during("open"), soft("comfort", 50.0))
      .minimise(
          "energy by day", [=](auto t, auto x, auto u) { return 3.0 * heat(t, x, u); },
          during("open"))
      .minimise("energy by night", heat, during("closed"))
      .track("calm", heat, VectorXd::Constant(1, 0.05))
      .data("house", House<double>{});
  OptimalControlProblem office("office");
  office.start_at({16, 16})
      .schedule(Schedule({"closed", "open", "closed", "open", "closed"},
                         {{"open 1", 8}, {"close 1", 18}, {"open 2", 32}, {"close 2", 42}}))
      .then(phase);

  MultipleShooting shooting{office, {.intervals_per_phase = 48, .integrator = zero_order_hold()}};
  RecedingHorizonController controller{std::move(shooting), {.period = period}};

  // House and weather differ slightly from the model.
  House<double> true_house{.losses = 0.14, .outside = 0.0};
  IntegratorPlant plant = make_plant<2, 1, size_of<House>>(Warmth{}, runge_kutta4(),
                                                           VectorXd{{16, 16}}, packed(true_house));
  const LoopLog log = simulate_closed_loop(controller, plant,
                                           {.duration = 48.0,
                                            .state_names = {"air [deg C]", "walls [deg C]"},
                                            .input_names = {"heat [kW]"},
                                            .before_tick = [&](double t, const VectorRef&) {
                                              if (t >= 20.0) controller.retime("open 2", 30.0);
                                              true_house.outside = t < 24.0 ? 0.0 : -3.0;
                                              plant.set_parameters(packed(true_house));
                                            }});
  std::printf("%s; %d of %zu ticks optimal, median %.2f ms\n", log.message.c_str(),
              log.count(Provenance::optimal), log.ticks.size(),
              1e3 * log.statistics.all().quantile(0.5));
  log.write("heating");
  return log.completed && log.count(Provenance::fallback) == 0 ? 0 : 1;
}
