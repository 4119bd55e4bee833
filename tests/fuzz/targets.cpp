#include "tests/fuzz/targets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>

#include "benchmarks/hanging_chain.hpp"
#include "benchmarks/recorded_sequence.hpp"
#include "benchmarks/suite/qp_file.hpp"
#include "problems/biped/survival/map_cells.hpp"
#include "problems/biped/survival/map_file.hpp"
#include "problems/library/npz.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/rerun.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/robots/model/mesh.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/yaml/yaml_section.hpp"

namespace saltus::fuzz {
namespace {

std::string text_of(Bytes bytes) { return {bytes.begin(), bytes.end()}; }
Bytes bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// One field of each kind that problems declare.
struct Fields {
  enum class Plant { centroidal, dart };
  double impulse = 7.0, friction = 0.5;
  std::optional<double> trigger;
  Eigen::Vector3d direction{0.0, -1.0, 0.0};
  int intervals = 15;
  bool stepping = true;
  std::string solver = "ipopt", urdf, preset = "robot";
  Plant plant = Plant::centroidal;

  Settings declared() {
    Settings settings;
    settings.number("push.impulse", impulse, "N s", "size", at_least(0.0));
    settings.number("push.trigger", trigger, "s", "when", at_least(0.0));
    settings.vector("push.direction", direction, "", "where to");
    settings.number("contact.friction", friction, "", "Coulomb's", above(0.0));
    settings.integer("horizon.intervals", intervals, "", "N", at_least(1));
    settings.flag("stepping", stepping, "may it step?");
    settings.choice("solver", solver, {"ipopt", "riccati", "sparse"}, "which");
    settings.choice<Plant>("plant", plant,
                           {{"centroidal", Plant::centroidal}, {"dart", Plant::dart}}, "which");
    settings.text("robot.urdf", urdf, "file");
    settings.choice("preset", preset, {"robot", "paper"}, "all");
    settings.preset("preset", {"paper"}, {"contact.friction=0.3", "push.trigger=0.1"});
    settings.preset("plant", {"dart"}, {"solver=riccati"});
    settings.alias("urdf", "robot.urdf");
    settings.renamed("push.size", "push.impulse", "9.0");
    settings.rule({"push.impulse", "push.trigger"}, [this] {
      return impulse > 100.0 && trigger ? "push.impulse exceeds 100 with push.trigger" : "";
    });
    return settings;
  }
};

// Written settings are read back unchanged.
void reads_back(Settings& settings) {
  const std::string written = settings.to_yaml();
  Fields again;
  Settings other = again.declared();
  try {
    other.apply(file_with(bytes_of(written), "written.yaml"), {});
  } catch (const InputError& error) {
    require(false, fmt::format("written, but not read back: {}\n{}", error.what(), written));
  }
  require(other.to_yaml() == written, fmt::format("read back differently:\n{}", written));
}

void settings_file(Bytes bytes) {
  Fields fields;
  Settings settings = fields.declared();
  settings.apply(file_with(bytes, "settings.yaml"), {});
  reads_back(settings);
}

// One word per line.
void command_line(Bytes bytes) {
  std::vector<std::string> words(1);
  for (const std::uint8_t byte : bytes) {
    if (byte == '\n')
      words.emplace_back();
    else if (byte != 0)  // no shell can pass a zero byte
      words.back() += static_cast<char>(byte);
  }
  const RunRequest request = parse_run_request(words);
  Fields fields;
  Settings settings = fields.declared();
  settings.apply(request.assignments);
  reads_back(settings);
}

void robot_file(Bytes bytes) {
  for (const robots::RobotDescription::Figures figures :
       {robots::RobotDescription::Figures::from_urdf, robots::RobotDescription::Figures::in_file})
    robots::parse_robot_description(text_of(bytes), "robot.yaml", figures);
}

void urdf(Bytes bytes) {
  const robots::UrdfModel model = robots::UrdfModel::parse(text_of(bytes), "robot.urdf");
  require(std::isfinite(model.total_mass()) && model.total_mass() > 0.0, "mass");
  robots::RobotDescription named;
  named.left_sole = model.link_names().front();
  named.right_sole = model.link_names().back();
  named.postures = {robots::StandingPosture{}};
  describe(model, named);
}

// The beginning of the bytes determines the format.
void mesh(Bytes bytes) {
  const std::string text = text_of(bytes.first(std::min<std::size_t>(bytes.size(), 2)));
  const char* name = text.starts_with('<')                             ? "mesh.dae"
                     : text.starts_with("v ") || text.starts_with('#') ? "mesh.obj"
                                                                       : "mesh.stl";
  require(!robots::mesh_corners(file_with(bytes, name)).empty(),
          "a mesh without a corner was accepted");
}

void npz(Bytes bytes) { library::read_npz(file_with(bytes, "arrays.npz").string()); }

void sequence(Bytes bytes) {
  const bench::RecordedSequence sequence = bench::read_sequence(file_with(bytes, "sequence.json"));
  if (!sequence.problems.empty() && sequence.intervals < 100) sequence.program(0);
}

void chain(Bytes bytes) { bench::read_chain(file_with(bytes, "chain.json")); }

void quadratic_program(Bytes bytes) { bench::read_program(file_with(bytes, "program.json")); }

void map_line(Bytes bytes) {
  const std::optional<robots::walking::MapRow> row = walking::from_line(text_of(bytes));
  if (row) require(walking::from_line(walking::to_line(*row)).has_value(), "a line not read back");
}

// The complete table of a map that is continued.
void map_file(Bytes bytes) {
  const std::string settings = "push:\n  impulse: 7\n";
  file_with(bytes_of(settings), robots::walking::map_settings);
  file_with(bytes, walking::map_csv);
  const robots::walking::MapFile map(own_folder(), settings);
}

// The settings file of a map. Other settings are compared with it.
void map_settings(Bytes bytes) {
  file_with(bytes, walking::map_settings);
  file_with(bytes_of(walking::map_header() + "\n" +
                     "mpc,0.6,270,7,recovered,5.2,,0.99,0.52,0.54,1.5,0.1,0.6,0.001,1,0,3.2,\n"),
            walking::map_csv);
  const robots::walking::MapFile map(own_folder(), "push:\n  impulse: 7\n  start: 1\n");
}

// Inputs that `saltus rerun` compares: two tables or two summaries, separated by a zero byte.
void compare(Bytes bytes, const std::string& name) {
  const auto middle = std::find(bytes.begin(), bytes.end(), 0);
  const std::filesystem::path before = own_folder() / "before", after = own_folder() / "after";
  std::filesystem::create_directory(before);
  std::filesystem::create_directory(after);
  file_with({bytes.begin(), middle}, "before/" + name);
  file_with({middle == bytes.end() ? middle : middle + 1, bytes.end()}, "after/" + name);
  const std::vector<FileComparison> found = compare_runs(before, after);
  std::filesystem::remove(before / name);
  std::filesystem::remove(after / name);
  require(found.size() == 1 && found[0].text.size() < 500,
          "one sentence names the difference of two runs");
}
void tables(Bytes bytes) { compare(bytes, "run.csv"); }
void summaries(Bytes bytes) { compare(bytes, "summary.json"); }

void run_file(Bytes bytes) {
  file_with(bytes, "run.json");
  file_with({}, "config.yaml");
  const std::string folder = own_folder().string();
  rerun(std::span(&folder, 1), {});  // no problem is registered, so none runs
}

void pushes(Bytes bytes) {
  robots::walking::MorePushes more;
  more.list = text_of(bytes);
  for (const robots::walking::Push& push : walking::all_pushes({}, more))
    require(std::isfinite(push.end()) && push.direction.allFinite(), "a push without an end");
}

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all{
      {"settings",
       settings_file,
       {"push:",
        "impulse:",
        "trigger: none",
        "direction: [0, -1, 0]",
        "contact.friction:",
        "horizon.intervals:",
        "stepping: false",
        "solver: sparse",
        "plant: dart",
        "preset: paper",
        "push.size:",
        "&a",
        "*a",
        "<<: *a",
        "!!int",
        "---",
        ".inf",
        ".nan",
        "1e400",
        "0x10"}},
      {"command_line",
       command_line,
       {"push_recovery\n", "--config\n", "--set\n", "--out\n", "--help\n", "--push.impulse\n",
        "--push.direction=[1,0,0]\n", "--stepping\n", "--plant=dart\n", "--preset\npaper\n",
        "--urdf\n", "-2\n", "--=\n"}},
      {"robot_file",
       robot_file,
       {"name:", "mass:", "left_foot:", "right_foot:", "sole:", "x: [-0.1, 0.1]", "postures:",
        "mirror:", "reversed:", "base:", "joints:", "com:", "other_foot:", "stance:", "capsules:"}},
      {"urdf",
       urdf,
       {"<robot name=\"r\">",
        "</robot>",
        "<link name=\"a\">",
        "<joint name=\"j\" type=\"revolute\">",
        "<parent link=\"a\"/>",
        "<child link=\"b\"/>",
        "<axis xyz=\"0 0 1\"/>",
        "<inertial>",
        "<mass value=\"1\"/>",
        "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
        "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>",
        "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
        "<collision>",
        "<geometry>",
        "<box size=\"1 1 1\"/>",
        "<mesh filename=\"m.stl\"/>",
        "1e308",
        "nan",
        "<!DOCTYPE a [<!ENTITY b \"bbbb\">]>",
        "&b;"}},
      {"mesh",
       mesh,
       {"solid a\n", "facet normal 0 0 1\n", "outer loop\n", "vertex 0 0 0\n", "endloop\n",
        "endfacet\n", "endsolid a\n"}},
      {"npz",
       npz,
       {"PK\x03\x04", "PK\x01\x02", "\x93NUMPY",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }"}},
      {"sequence", sequence, {"\"intervals\"", "\"problems\"", "\"landing\"", "null", "1e999"}},
      {"chain", chain, {"\"reference\"", "\"start\"", "null"}},
      {"quadratic_program",
       quadratic_program,
       {"\"format\"", "\"saltus-qp 1\"", "\"hessian\"", "\"jacobian\"", "\"gradient\"", "\"row\"",
        "\"col\"", "\"value\"", "\"stages\"", "\"guess\"", "\"warm\"", "\"optimum\"", "null"}},
      {"map_line", map_line, {",recovered,", ",not_run,", "mpc,", "capture_point,", "nan"}},
      {"map_file",
       map_file,
       {walking::map_header() + "\n", ",recovered,", ",not_run,", "mpc,", "capture_point,", "nan"}},
      {"map_settings", map_settings, {"push:\n", "  impulse: 7\n", "  start: 1\n", "  # ", "- "}},
      {"tables", tables, {"t [s],x\n", "solve time [s]", ",,", "\n0,1\n", std::string(1, '\0')}},
      {"summaries",
       summaries,
       {"{\"a\":", "[[[[", "null", "1e999", "\"solve_us\":", "\xff", "\\ud800",
        std::string(1, '\0')}},
      {"run_file",
       run_file,
       {"{\"problem\":", "\"folder\":", "\"saltus\":", "null", "\xff", "\\u0000"}},
      {"pushes", pushes, {"; ", "3.2 6 90", " 0.1", "nan", "inf", "1e308", "0x1p3"}}};
  return all;
}

}  // namespace saltus::fuzz
