// Writes data/step_recovery_sequence.json: the closed loop of controller and nonlinear plant.
//
// The plant is the full centroidal model, H' = sum tau_i + (x_i - x) x f_i with the moving CoM x,
// integrated by RK4 in substeps; the controller plans with H' linearised about the CoM of its
// start. The controller receives the state of the plant with noise, uniform within 1 mm, 5 mm/s and
// 0.02 Nms.
//
// Usage: record_sequence FILE
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "benchmarks/recorded_sequence.hpp"
#include "benchmarks/step_recovery_kernels.hpp"
#include "saltus/app/program.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"

namespace {

using namespace saltus;
using namespace saltus::bench;

constexpr int ticks = 60, intervals = 15, substeps = 10, seed = 1;
constexpr double noise[3] = {1e-3, 5e-3, 0.02};  // m, m/s, Nms

nlohmann::ordered_json record() {
  robots::CentroidalPlant plant(StepRecovery::mass, nominal_start(),
                                runge_kutta4({.steps = substeps}));
  plant.left = {robots::flat_sole(Vec<double, 3>(StepRecovery::left_foot.data())), true};
  plant.right = {robots::flat_sole(Vec<double, 3>(StepRecovery::right_foot.data())), false};
  Random random(seed);
  nlohmann::ordered_json problems = nlohmann::ordered_json::array();
  for (int tick = 0; tick < ticks; ++tick) {
    const int landing = landing_at(tick);
    saltus::bench::CentroidalState start = plant.state();
    if (tick > 0)
      for (int i = 0; i < 9; ++i) start[i] += random.uniform(-noise[i / 3], noise[i / 3]);
    problems.push_back(
        {{"landing", landing}, {"start", std::vector<double>(start.begin(), start.end())}});

    const qp::StageQp qp = step_recovery_qp({intervals, landing}, start);
    qp::StagePoint point = standing_guess(qp);
    const auto solver = qp::make_riccati_solver(qp, from_standing(), step_recovery_kernels);
    const qp::QpResult result = solver->solve(qp, point, /*warm=*/false);
    if (result.status != qp::QpStatus::optimal)
      throw std::runtime_error(fmt::format("tick {}: {}", tick, describe(result.status)));
    Vec<double, 12> wrenches = Vec<double, 12>::Zero();
    const int inputs = qp.stages[0].nu;
    for (int i = 0; i < inputs; ++i)
      wrenches[i] =
          point.stages[0].u[i] * (i % 6 < 3 ? StepRecovery::force_unit : StepRecovery::torque_unit);
    plant.right.in_contact = landing == 0;
    if (plant.advance(StepRecovery::tick, wrenches) != IntegrationStatus::success)
      throw std::runtime_error(fmt::format("tick {}: the plant could not be integrated", tick));
  }
  const auto& x = plant.state();
  fmt::print("at the end the CoM is at ({:.3f}, {:.3f}, {:.3f}) m and moves with {:.3f} m/s\n",
             x[0], x[1], x[2], x.segment<3>(3).norm());
  return {{"about",
           "Consecutive step-recovery programs of a closed loop, written by record_sequence: first "
           "stage with both feet, and the measured state (m, m/s, Nms)."},
          {"intervals", intervals},
          {"problems", problems}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw InputError("record_sequence needs one argument, the file to write");
  const std::filesystem::path file = argv[1];
  const OutputFolder folder(file.has_parent_path() ? file.parent_path() : ".");
  // Writes one problem per line.
  const nlohmann::ordered_json data = record();
  std::string text = fmt::format("{{\n  \"about\": {},\n  \"intervals\": {},\n  \"problems\": [\n",
                                 data["about"].dump(), data["intervals"].dump());
  for (std::size_t i = 0; i < data["problems"].size(); ++i)
    text += fmt::format("    {}{}\n", data["problems"][i].dump(),
                        i + 1 < data["problems"].size() ? "," : "");
  folder.write(file.filename().string(), std::string_view(text + "  ]\n}\n"));
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "record_sequence: {}\n", error.what());
  return 1;
}
