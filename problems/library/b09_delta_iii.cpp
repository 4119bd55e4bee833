// Ascent of a Delta III into a transfer orbit with maximum final mass. It has nine solid boosters,
// of which six burn from the start and three later, and two stages.
//
//   r' = v, v' = T/m u/|u| - mu r/|r|^3 + D/m, m' = -mdot   |u| = 1
//   D = -1/2 rho S Cd |w| w, w = v - cross(omega, r), rho = 1.225 exp(-(|r| - Re) / 7200)
//   t = 0, 75.2, 150.4, 261 s, free; empty boosters and stages are dropped there
//   end: a = 24361140 m, e = 0.7308, i = 28.5, Omega = 269.8, argument of perigee 130.5 degrees
//
// The five orbital elements are imposed through the angular momentum and the two components of the
// eccentricity vector in the plane of the orbit, which are smooth. The thrust has the direction of
// u, so a piecewise linear u does not reduce its magnitude between the nodes; |u| = 1 at the nodes
// fixes the length.
// Guess: a trajectory up and to the east, 30, 80, 150 and 200 km high and 1, 2, 4.5 and 8 km/s fast
// at the ends of the phases, with the masses of the burn, thrust pitched over by 5, 25, 55 and 80
// degrees, and 650 s for the second stage. If the guess is at rest on the ground, the simulated
// intervals fall into the Earth. With vertical thrust Ipopt needed 40 iterations, or did not finish
// in 500, depending on the processor and its linear algebra.
// Source: Benson 2005, Betts 2010; PSOPT examples, launch, 7529.661 kg; the optimum was computed
// independently.
#include <cmath>
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double radius = 6378145.0;          // radius of the Earth, m
constexpr double mu = 3.986012e14;            // m^3/s^2
constexpr double earth_rate = 7.29211585e-5;  // rad/s
constexpr double scale_height = 7200.0;       // scale height of the atmosphere, m
constexpr double half_rho_S_Cd = 0.5 * 1.225 * 4.0 * std::numbers::pi * 0.5;  // kg/m
constexpr double degree = std::numbers::pi / 180.0;

constexpr double booster_total = 19290.0, booster_fuel = 17010.0, booster_burn = 75.2;  // kg, s
constexpr double booster_empty = booster_total - booster_fuel;                          // kg
constexpr double first_total = 104380.0, first_fuel = 95550.0, first_burn = 261.0;      // kg, s
constexpr double second_total = 19300.0, second_fuel = 16820.0, second_burn = 700.0;    // kg, s
constexpr double payload = 4164.0;                                                      // kg
constexpr double booster_thrust = 628500.0, first_thrust = 1083100.0;                   // N
constexpr double second_thrust = 110094.0;                                              // N

template <class V>
using Entry = std::decay_t<decltype(std::declval<V>()[0])>;

template <class S>
S length(const Vec<S, 3>& a) {
  return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

struct Rocket {      // x = (r, v, m)
  double thrust;     // N
  double fuel_rate;  // kg/s
  template <class S>
  Vec<S, 7> operator()(const S&, const Vec<S, 7>& x, const Vec<S, 3>& u) const {
    const Vec<S, 3> r{x[0], x[1], x[2]};
    const Vec<S, 3> w{x[3] + earth_rate * x[1], x[4] - earth_rate * x[0], x[5]};
    const S distance = length(r), mass = x[6];
    const S push = thrust / (mass * length(u));
    const S weight = -mu / (distance * distance * distance);
    const S drag = -half_rho_S_Cd * exp(-(distance - radius) / scale_height) * length(w) / mass;
    return {x[3],
            x[4],
            x[5],
            push * u[0] + weight * x[0] + drag * w[0],
            push * u[1] + weight * x[1] + drag * w[1],
            push * u[2] + weight * x[2] + drag * w[2],
            S(-fuel_rate)};
  }
};

// Axes of the transfer orbit: normal of its plane, perigee, and a quarter turn ahead of the
// perigee.
struct Orbit {
  double a = 24361140.0, e = 0.7308;  // m, -
  double inclination = 28.5 * degree, node = 269.8 * degree, perigee = 130.5 * degree;

  double angular_momentum() const { return std::sqrt(mu * a * (1.0 - e * e)); }  // m^2/s
  Vec<double, 3> normal() const {
    return {std::sin(inclination) * std::sin(node), -std::sin(inclination) * std::cos(node),
            std::cos(inclination)};
  }
  // Direction in the plane at an angle from the ascending node.
  Vec<double, 3> direction(double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {std::cos(node) * c - std::sin(node) * std::cos(inclination) * s,
            std::sin(node) * c + std::cos(node) * std::cos(inclination) * s,
            std::sin(inclination) * s};
  }
};

OptimalControlProblem problem() {
  const Orbit orbit;
  const Vec<double, 3> h = orbit.angular_momentum() * orbit.normal() / std::sqrt(mu * radius);
  const Vec<double, 3> to_perigee = orbit.direction(orbit.perigee);
  const Vec<double, 3> ahead = orbit.direction(orbit.perigee + std::numbers::pi / 2);

  const auto angular_momentum = [](const auto&, const auto& x) {  // over a circular orbit at Re
    using S = Entry<decltype(x)>;
    const Vec<S, 3> r{x[0], x[1], x[2]}, v{x[3], x[4], x[5]};
    return Vec<S, 3>{r.cross(v) / std::sqrt(mu * radius)};
  };
  const auto eccentricity = [=](const auto&, const auto& x) {
    using S = Entry<decltype(x)>;
    const Vec<S, 3> r{x[0], x[1], x[2]}, v{x[3], x[4], x[5]};
    const Vec<S, 3> e = v.cross(r.cross(v)) / mu - r / length(r);
    return Vec<S, 2>{e[0] * to_perigee[0] + e[1] * to_perigee[1] + e[2] * to_perigee[2],
                     e[0] * ahead[0] + e[1] * ahead[1] + e[2] * ahead[2]};
  };
  const auto altitude = [](const auto&, const auto& x) {  // radii of the Earth
    using S = Entry<decltype(x)>;
    return S(length(Vec<S, 3>{x[0], x[1], x[2]}) / radius - 1.0);
  };
  const auto steering = [](const auto&, const auto&, const auto& u) {
    return u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
  };
  const auto minus_mass = [](const auto&, const auto& x) { return -x[6]; };
  const auto drop = [](std::string name, double mass) {
    return jump<7>(std::move(name), [mass](const auto&, const auto& x) {
      return decltype(x.eval()){x[0], x[1], x[2], x[3], x[4], x[5], x[6] - mass};
    });
  };

  const double booster_rate = booster_fuel / booster_burn, first_rate = first_fuel / first_burn;
  const double third_phase = first_burn - 2.0 * booster_burn;
  Phase<7, 3> six{"six boosters",
                  Rocket{6 * booster_thrust + first_thrust, 6 * booster_rate + first_rate},
                  exactly(booster_burn)};
  Phase<7, 3> three{"three boosters",
                    Rocket{3 * booster_thrust + first_thrust, 3 * booster_rate + first_rate},
                    exactly(booster_burn)};
  Phase<7, 3> first{"first stage", Rocket{first_thrust, first_rate}, exactly(third_phase)};
  Phase<7, 3> second{"second stage", Rocket{second_thrust, second_fuel / second_burn},
                     between(100.0, second_burn)};
  second
      .reach("plane and angular momentum", angular_momentum,
             {exactly(h[0]), exactly(h[1]), exactly(h[2])})
      .reach("eccentricity and perigee", eccentricity, {exactly(orbit.e), exactly(0.0)})
      .minimise_at_end("mass", minus_mass)
      .guess_duration(650.0)
      .nominal_duration(100.0);

  const Vec<double, 3> up{std::cos(28.5 * degree), 0.0, std::sin(28.5 * degree)};
  Vec<double, 7> start;
  start << radius * up, 0.0, earth_rate * radius * up[0], 0.0,
      payload + second_total + first_total + 9 * booster_total;
  Vec<double, 7> nominal;
  nominal << Vec<double, 3>::Constant(radius), Vec<double, 3>::Constant(std::sqrt(mu / radius)), 0;

  OptimalControlProblem ocp("Delta III");
  ocp.start_at(start);
  double mass = start[6];
  Vec<double, 6> reached = start.head<6>();
  const Vec<double, 3> east{0.0, 1.0, 0.0};
  // Mean pitch from the vertical.
  const auto add = [&](Phase<7, 3>& phase, double burnt, double height, double speed, double pitch,
                       Jump jump) {
    Vec<double, 7> begins = start, ends = start;
    begins.head<6>() = reached;
    reached << (radius + height) * up, 0.0, speed, 0.0;  // m, m/s
    ends.head<6>() = reached;
    begins[6] = mass;
    ends[6] = mass -= burnt;
    nominal[6] = begins[6];
    phase.inputs(InputParametrisation::piecewise_linear_continuous)
        .keep("unit steering", steering, exactly(1.0))
        .allow("unit steering", 1e-2)  // chord between two directions; dynamics normalise
        .keep("above ground", altitude, at_least(0.0))
        .nominal(nominal, Vec<double, 3>::Ones())
        .guess_state(Guess::interpolate(begins, ends))
        .guess_input(Guess::constant(std::cos(pitch) * up + std::sin(pitch) * east));
    if (jump.map)
      ocp.then(phase, std::move(jump));
    else
      ocp.then(phase);
  };
  add(six, 6 * booster_fuel + first_rate * booster_burn, 3e4, 1000.0, 5.0 * degree, {});
  mass -= 6 * booster_empty;
  add(three, 3 * booster_fuel + first_rate * booster_burn, 8e4, 2000.0, 25.0 * degree,
      drop("six boosters", 6 * booster_empty));
  mass -= 3 * booster_empty;
  add(first, first_rate * third_phase, 1.5e5, 4500.0, 55.0 * degree,
      drop("three boosters", 3 * booster_empty));
  mass -= first_total - first_fuel;
  add(second, second_fuel * 650.0 / second_burn, 2e5, 8000.0, 80.0 * degree,
      drop("first stage", first_total - first_fuel));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  // The mass decreases by 24 kg/s until the end, so an error of the mass is an error of the time.
  return {{"T", solution.trajectory.end_time(), 924.139203, 3e-4, 9}};
}

}  // namespace

ReferenceCase delta_iii() {
  return {.id = "B09",
          .name = "delta_iii",
          .summary = "Ascent of a Delta III into a transfer orbit: four phases, boosters dropped.",
          .states = {"rx [m]", "ry [m]", "rz [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]", "mass [kg]"},
          .inputs = {"ux", "uy", "uz"},
          .exercises =
              "four phases, drops of mass, a free end, quantities of very different magnitudes",
          .source = "Benson 2005; PSOPT examples, launch; optimum computed independently",
          .problem = problem,
          .options = {.intervals = {6, 6, 6, 24}, .integrator = runge_kutta8()},
          .optimum = -7529.712296,
          .digits = 10,
          .tolerance = 1e-6,      // piecewise linear inputs cost an excess of order h^4
          .between_nodes = 1e-2,  // for |u|^2, which has no effect there; not for the altitude
          .more = more,
          // A twentieth of the radius below ground the density is e^44 times larger, and in longer
          // intervals the guess of the second stage falls that far. The density changes by 1 % over
          // a hundred-thousandth of the radius; smaller steps lose digits of the Hessian.
          .derivatives = {.intervals = 24, .radius = 1e-3, .step = 1e-7, .tolerance = 1e-5}};
}

}  // namespace saltus::library
