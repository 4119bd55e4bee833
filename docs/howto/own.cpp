// User-defined data, integrator and plant: a cart on a road with a measured slope.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "cart.hpp"

// The slope along the road, linear between the points of a table: the first value, and a change of
// its rate at every point.
struct Road {
  std::vector<double> places, bends;  // m; changes of the slope's rate, 1/m
  double first = 0.0;

  explicit Road(const std::filesystem::path& table) {
    std::ifstream file(table);
    std::string line;
    std::getline(file, line);  // column titles
    double before = 0.0, slope = 0.0, rate = 0.0;
    for (double place; std::getline(file, line);) {
      std::replace(line.begin(), line.end(), ',', ' ');
      if (!(std::istringstream(line) >> place >> slope)) break;
      if (places.empty()) {
        first = slope;
      } else {
        const double next = (slope - before) / (place - places.back());
        bends.push_back(next - rate);
        rate = next;
      }
      places.push_back(place);
      before = slope;
    }
    bends.push_back(-rate);  // constant slope behind the last point
  }

  template <class S>
  S operator()(const S& place) const {
    S slope(first);
    for (std::size_t i = 0; i < places.size(); ++i)
      slope += bends[i] * max(S(place - places[i]), 0.0);
    return slope;
  }
};

struct CartOnRoad {  // x = (position m, speed m/s), u = force per mass, m/s^2
  Road road;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 9.81 * road(x[0])};
  }
};

// An external simulator, here with steps of 1 ms and friction of the wheel.
class Simulator final : public LoopPlant {
 public:
  explicit Simulator(const Road& road) : road_(road) {}

  double time() const override { return time_; }
  VectorXd state() const override { return x_; }
  int inputs() const override { return 1; }
  bool advance(const VectorRef& input, double length) override {
    const int steps = static_cast<int>(std::ceil(1000.0 * length));
    for (int i = 0; i < steps; ++i) {
      x_[1] += length / steps * (input[0] - 9.81 * road_(x_[0]) - 0.3 * std::tanh(x_[1] / 0.01));
      x_[0] += length / steps * x_[1];
    }
    time_ += length;
    return true;
  }

 private:
  Road road_;
  double time_ = 0.0;
  VectorXd x_ = VectorXd::Zero(2);
};

int main() {
  const Road road(std::filesystem::path(__FILE__).parent_path() / "road.csv");

  // Ralston's method: the second-order method with two stages and the smallest error bound.
  const ButcherTableau ralston{.name = "Ralston",
                               .order = 2,
                               .a = MatrixXd{{0.0, 0.0}, {2.0 / 3.0, 0.0}},
                               .b = VectorXd{{0.25, 0.75}},
                               .c = VectorXd{{0.0, 2.0 / 3.0}}};

  Phase<2, 1> ahead{"ahead", CartOnRoad{road}, exactly(1.0)};
  ahead.bound_input(0, between(-6.0, 6.0))
      .track(
          "place", [](auto, auto x) { return 2.0 - x[0]; }, VectorXd::Constant(1, 10.0))
      .track("speed", speed, VectorXd::Constant(1, 1.0))
      .track("effort", pull, VectorXd::Constant(1, 0.01));
  OptimalControlProblem problem("over the hill");
  problem.start_at({0.0, 0.0}).then(ahead);

  RecedingHorizonController controller{
      MultipleShooting(
          problem, {.intervals_per_phase = 25, .integrator = runge_kutta(ralston, {.steps = 2})}),
      {.period = 0.02}};
  Simulator simulator(road);
  const LoopLog log = simulate_closed_loop(controller, simulator, {.duration = 5.0});
  const double left = std::abs(log.final_state()[0] - 2.0);
  std::printf("%s; within 5 cm of 2 m: %s\n", log.message.c_str(), left < 0.05 ? "yes" : "no");
  return log.completed && left < 0.05 ? 0 : 1;
}
