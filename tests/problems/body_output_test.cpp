// The files of a run on the whole body. With SALTUS_ICUB_URDF and SALTUS_BODY_RUN=FOLDER a real run
// is written into that folder, pictures and replay included; SALTUS_BODY_SETTINGS="KEY=VALUE ..."
// changes its settings.
#include "problems/biped/report/body_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "problems/push_recovery/push_recovery.hpp"
#include "saltus/core/error.hpp"

namespace saltus::push_recovery {
namespace {

constexpr double period = 0.002;  // s
constexpr int samples = 40;
constexpr int landing = 20;  // sample from which both feet stand
// Rounding in sums of at most forty numbers below 1000.
constexpr double rounding = 1e-9;

robots::FloatingRobot two_joints() {
  robots::FloatingRobot robot;
  robot.name = "hopper";
  robot.total_mass = 3.0;
  robots::FloatingRobot::Body base, thigh, shin;
  base.name = "trunk";
  thigh.name = "thigh";
  thigh.parent = 0;
  thigh.joint = "hip";
  thigh.effort = 10.0;
  shin.name = "shin";
  shin.parent = 1;
  shin.joint = "knee";
  shin.effort = 20.0;
  shin.boxes.push_back({Eigen::Isometry3d::Identity(), {0.2, 0.1, 0.02}});
  robots::UrdfModel::LinkShape visual;
  visual.shape = robots::UrdfModel::LinkShape::Shape::mesh;
  visual.mesh = "package://hopper/shin.stl";
  visual.size.setConstant(0.001);
  shin.looks.push_back({"shin", {visual}, shin.boxes});
  robot.source = "hopper.urdf";
  robot.bodies = {base, thigh, shin};
  robot.left_sole.body = robot.right_sole.body = 2;
  return robot;
}

// The left sole is rotated by 90 degrees about z. Both soles slide. The foot that is not the stance
// foot lands.
RunLog made_up_log(robots::Side stance = robots::Side::left) {
  RunLog log;
  for (int i = 0; i < samples; ++i) {
    BipedSample s;
    s.time = i * period;
    s.gamma.setZero();
    s.capture_point.setZero();
    s.wrenches.setZero();
    s.push.setZero();
    (stance == robots::Side::left ? s.right_stands : s.left_stands) = i >= landing;
    log.samples.push_back(s);
    RunLog::BodySample b;
    b.state.q = VectorXd::Constant(2, 0.1 * i);
    b.state.dq = VectorXd::Zero(2);
    b.torques = Vec<double, 2>(-0.1 * i, 0.15 * i);
    b.planned.setConstant(5.0);
    b.left << 1.0, 2.0, i, 0.0, 0.0, 0.0;
    b.right.setZero();
    b.left_sole = b.right_sole = Eigen::Isometry3d::Identity();
    b.left_sole.rotate(Eigen::AngleAxisd(std::acos(0.0), Vec<double, 3>::UnitZ()));
    b.left_sole.translation()[0] = 1e-4 * i;
    b.right_sole.translation()[1] = -1e-3 * i;
    log.body.push_back(b);
  }
  return log;
}

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  double at(int row, const std::string& column) const {
    const auto found = std::ranges::find_if(columns, [&](const std::string& name) {
      return name.substr(0, name.find(" [")) == column;
    });
    EXPECT_NE(found, columns.end()) << column;
    if (found == columns.end()) return std::nan("");
    return rows.at(static_cast<std::size_t>(row))
        .at(static_cast<std::size_t>(found - columns.begin()));
  }
};

Table parse(const CsvTable& csv) {
  Table table;
  std::istringstream text(csv.text());
  for (std::string line; std::getline(text, line);) {
    std::istringstream entries(line);
    std::vector<double> row;
    for (std::string entry; std::getline(entries, entry, ',');) {
      if (table.rows.empty() && std::isalpha(entry.front()) != 0)
        table.columns.push_back(entry);
      else
        row.push_back(std::stod(entry));
    }
    if (!row.empty()) table.rows.push_back(row);
  }
  return table;
}

TEST(BodyOutput, WritesOneFiniteRowPerSample) {
  const Table table = parse(body_table(made_up_log(), two_joints()));
  // t, base, two joints with angle, torque and speed, three kinds of two wrenches, two soles,
  // slips, friction.
  const std::size_t width = 1 + 7 + 3 * 2 + 3 * 2 * 6 + 2 * 7 + 2 + 2;
  EXPECT_EQ(table.columns.size(), width);
  ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(samples));
  for (const auto& row : table.rows) {
    ASSERT_EQ(row.size(), width);
    for (const double value : row) EXPECT_TRUE(std::isfinite(value));
  }
  EXPECT_EQ(table.at(7, "q_knee"), 0.1 * 7);
  EXPECT_EQ(table.at(7, "tau_hip"), -0.1 * 7);
  EXPECT_EQ(table.at(7, "right_planned_tz"), 5.0);
  EXPECT_EQ(table.at(7, "base_qw"), 1.0);
  EXPECT_NEAR(table.at(7, "left_sole_qz"), std::sqrt(0.5), rounding);
}

TEST(BodyOutput, RotatesAndFiltersMeasuredWrenches) {
  const Table table = parse(body_table(made_up_log(), two_joints()));
  EXPECT_NEAR(table.at(3, "left_measured_fx"), 2.0, rounding);  // the world's y is the sole's x
  EXPECT_NEAR(table.at(3, "left_measured_fy"), -1.0, rounding);
  EXPECT_NEAR(table.at(3, "left_measured_fz"), 3.0, rounding);
  const int window = static_cast<int>(std::lround(wrench_filter / period));
  // The force is the index of its sample: its mean lags by half a window, or is half the value at
  // the start.
  EXPECT_NEAR(table.at(30, "left_filtered_fz"), 30.0 - 0.5 * (window - 1), rounding);
  EXPECT_NEAR(table.at(4, "left_filtered_fz"), 2.0, rounding);
}

TEST(BodyOutput, SlipIsRelativeToTheInitialContact) {
  const Table table = parse(body_table(made_up_log(), two_joints()));
  EXPECT_NEAR(table.at(30, "left_slip"), 1e-4 * 30, rounding);
  EXPECT_EQ(table.at(landing - 1, "right_slip"), 0.0);
  EXPECT_NEAR(table.at(30, "right_slip"), 1e-3 * (30 - landing), rounding);
}

TEST(BodyOutput, SlipOfTheSwingFootIsRelativeToItsLanding) {
  const RunLog log = made_up_log(robots::Side::right);
  const Table table = parse(body_table(log, two_joints()));
  EXPECT_EQ(table.at(landing - 1, "left_slip"), 0.0);
  EXPECT_NEAR(table.at(30, "left_slip"), 1e-4 * (30 - landing), rounding);
  EXPECT_NEAR(table.at(30, "right_slip"), 1e-3 * 30, rounding);
}

TEST(BodyOutput, FrictionIsTheForceRatioOfALoadedFoot) {
  const Table table = parse(body_table(made_up_log(), two_joints()));
  EXPECT_EQ(table.at(0, "left_friction"), 0.0);  // without load
  EXPECT_NEAR(table.at(30, "left_friction"), std::sqrt(5.0) / 30.0, rounding);
  EXPECT_EQ(table.at(30, "right_friction"), 0.0);
}

// The left foot's force is the index of its sample; the right one's, for a whole window, 50 N.
TEST(BodyOutput, ReportsThePeakForceOfEachFoot) {
  RunLog log = made_up_log();
  const int window = static_cast<int>(std::lround(wrench_filter / period));
  for (int i = 0; i < window; ++i) log.body[5 + i].right[2] = 50.0;
  const auto figures = body_figures(log, two_joints());
  EXPECT_NEAR(figures["left_force_peak_n"].get<double>(), samples - 1 - 0.5 * (window - 1),
              rounding);
  EXPECT_NEAR(figures["right_force_peak_n"].get<double>(), 50.0, rounding);
}

TEST(BodyOutput, ReportsTheJointNearestToItsLimit) {
  const auto figures = body_figures(made_up_log(), two_joints());
  EXPECT_NEAR(figures["torque_share_max"].get<double>(), 0.1 * (samples - 1) / 10.0, rounding);
  EXPECT_EQ(figures["torque_share_joint"], "hip");
  RunLog log = made_up_log();
  for (RunLog::BodySample& b : log.body) b.torques[1] = -13.0;
  const auto of_knee = body_figures(log, two_joints());
  EXPECT_EQ(of_knee["torque_share_max"], 13.0 / 20.0);
  EXPECT_EQ(of_knee["torque_share_joint"], "knee");
  EXPECT_NEAR(figures["left_slip_max_m"].get<double>(), 1e-4 * (samples - 1), rounding);
}

// The estimate of the CoM has errors of 3 mm and 0.1 m/s, that of the sole 1 mm. A step changes the
// stance sole.
TEST(BodyOutput, WritesEstimateAndTruth) {
  RunLog log = made_up_log();
  const std::size_t width = parse(body_table(log, two_joints())).columns.size();
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    log.samples[i].time += 1.0;  // s; long after the start
    RunLog::BodySample& b = log.body[i];
    const robots::Side stance = 2 * i < log.body.size() ? robots::Side::left : robots::Side::right;
    const Vec<double, 3> sole =
        (stance == robots::Side::left ? b.left_sole : b.right_sole).translation();
    RunLog::BodyEstimate estimate{b.state, log.samples[i].gamma,
                                  sole + Vec<double, 3>(1e-3, 0.0, 0.0), stance};
    estimate.gamma[0] += 4e-3;
    estimate.gamma[3] += 0.1;
    b.estimate = estimate;
  }
  RunLog early = log;  // ends before the filter has converged: no estimate
  for (BipedSample& s : early.samples) s.time -= 1.0;
  const auto none = body_figures(early, two_joints());
  EXPECT_TRUE(none["estimate_com_error_m"].is_null());
  EXPECT_TRUE(none["estimate_velocity_error_m_s"].is_null());
  const auto figures = body_figures(log, two_joints());
  EXPECT_NEAR(figures["estimate_com_error_m"].get<double>(), 3e-3, rounding);
  EXPECT_NEAR(figures["estimate_velocity_error_m_s"].get<double>(), 0.1, rounding);
  const Table table = parse(body_table(log, two_joints()));
  // Pose of the base, positions and velocities of two joints, CoM with momentum, sole and its side.
  EXPECT_EQ(table.columns.size(), width + 7 + 4 + 9 + 4);
  EXPECT_NEAR(table.at(3, "estimate_com_x"), log.samples[3].gamma[0] + 4e-3, rounding);
  EXPECT_NEAR(table.at(3, "estimate_dq_knee"), log.body[3].state.dq[1], rounding);
}

TEST(BodyOutput, WritesEstimatesOfMassAndCom) {
  RunLog log = made_up_log();
  EXPECT_FALSE(body_figures(log, two_joints()).contains("estimated_mass_kg"));
  log.mass_estimate = {31.5, {0.01, -0.02, 0.0}};
  const auto figures = body_figures(log, two_joints());
  EXPECT_EQ(figures["estimated_mass_kg"], 31.5);
  EXPECT_EQ(figures["estimated_com_shift_m"][1], -0.02);
}

TEST(BodyOutput, ShapeContainsEveryBodyAndItsBoxes) {
  const RunLog log = made_up_log();
  const auto shape = robot_shape(two_joints(), log.robot.left_foot, log.robot.right_foot);
  ASSERT_EQ(shape["bodies"].size(), 3u);
  EXPECT_EQ(shape["bodies"][2]["parent"], 1);
  EXPECT_EQ(shape["bodies"][2]["joint"], "knee");
  EXPECT_EQ(shape["bodies"][2]["boxes"][0]["size"][1], 0.1);
  EXPECT_EQ(shape["left_sole"]["body"], 2);
  EXPECT_EQ(shape["urdf"], std::filesystem::absolute("hopper.urdf").string());
  EXPECT_TRUE(shape["bodies"][0]["looks"].empty());
  const auto& look = shape["bodies"][2]["looks"][0];
  EXPECT_EQ(look["link"], "shin");
  EXPECT_EQ(look["visuals"][0]["shape"], "mesh");
  EXPECT_EQ(look["visuals"][0]["mesh"], "package://hopper/shin.stl");
  EXPECT_EQ(look["visuals"][0]["size"][2], 0.001);
  EXPECT_EQ(look["boxes"][0]["size"][0], 0.2);
}

TEST(BodyOutput, RejectsALogOfAnotherRobot) {
  RunLog log = made_up_log();
  log.body.back().torques.resize(3);
  EXPECT_THROW(body_table(log, two_joints()), DefinitionError);
  log = made_up_log();
  log.body.pop_back();
  EXPECT_THROW(body_table(log, two_joints()), DefinitionError);
}

TEST(BodyOutput, IsCompleteAfterARealRun) {
  const char* folder = std::getenv("SALTUS_BODY_RUN");
  const char* urdf = std::getenv("SALTUS_ICUB_URDF");
  if (folder == nullptr || urdf == nullptr)
    GTEST_SKIP() << "SALTUS_BODY_RUN and SALTUS_ICUB_URDF do not name a folder and a URDF";
  RunRequest request;
  request.out = folder;
  const char* more = std::getenv("SALTUS_BODY_SETTINGS");
  std::istringstream settings(std::string("plant=dart ") +
                              (more == nullptr ? "push.impulse=6 push.start=0.6" : more));
  for (std::string setting; settings >> setting;)
    request.assignments.push_back(parse_set_argument(setting));
  EXPECT_EQ(entry().run(request), ExitStatus::ok);
  for (const char* file : {"body.csv", "robot.json", "summary.json"})
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(folder) / file)) << file;
}

}  // namespace
}  // namespace saltus::push_recovery
