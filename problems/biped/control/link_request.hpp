// Common parts of the verbs with a robot in another process: `control`, `robot check`, `robot
// serve` and `robot play`.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/robots/control/control_process.hpp"

namespace saltus::robots::walking {

/// Options of these verbs.
struct LinkRequest {
  std::string link;                             ///< address
  std::optional<std::filesystem::path> config;  ///< settings of push_recovery
  std::filesystem::path robot;                  ///< robot file; empty: none
  std::filesystem::path out;                    ///< folder of the log
  std::vector<Assignment> assignments;          ///< settings of push_recovery
  control::ControlOptions control;              ///< states and guards
  control::ProcessOptions process;              ///< loop
  control::RealTimeOptions real_time;           ///< operating system
  int log_every = 5;                            ///< log every n-th command
};

/// Declares options with a parser, for messages of the verb `verb`.
class LinkOptions {
 public:
  LinkOptions(OptionParser& parser, std::string verb, LinkRequest& request);

  /// A number of at least `least`.
  void number(const char* flag, const char* what, const char* doc, double least, double& field);
  /// A whole number of at least `least`.
  void integer(const char* flag, const char* doc, double least, std::function<void(int)> take);
  /// --link.
  void link();
  /// --robot.
  void robot();
  /// --config, --set and --KEY of push_recovery.
  void settings();
  /// --out, --wait, --log-every and the options for real time.
  void process(const std::string& folder);

 private:
  OptionParser& parser_;
  std::string verb_;
  LinkRequest& request_;
};

/// Applies the settings of the request, with the whole body in DART unless they name a plant.
/// Returns them as YAML. Throws InputError if the sensors are ideal.
std::string apply_settings(const LinkRequest& request, ConfigurableBiped& problem);

/// The robot as simulated by others, the model of the controller, and the state at the start.
struct BipedModel {
  FloatingRobot body, nominal;
  WholeBodyState start;
};
/// Model of the robot of these settings.
BipedModel make_model(const BipedProblem& problem, const RobotDescription& robot);

/// A robot with these joints, and their names for the log.
struct LinkSetup {
  std::vector<control::LinkJoint> joints = {};  ///< joints of the robot
  control::ControlOptions options = {};         ///< states and guards
  std::string name = {};                        ///< name of the robot
  std::string config = {};                      ///< settings of push_recovery as YAML, or empty
};
/// Setup of a biped, after reading the robot file.
LinkSetup biped_setup(const LinkRequest& request, const BipedProblem& problem,
                      const BipedModel& model, std::string config);

/// Drives the robot, writes the log and prints the result. `more` returns further entries of
/// summary.json.
ExitStatus drive(const LinkRequest& request, const LinkSetup& setup,
                 control::LinkController& controller,
                 const std::function<nlohmann::ordered_json()>& more);

/// Quantiles for summary.json.
nlohmann::ordered_json to_json(const LatencyHistogram& times);
/// Prints quantiles in one line, or nothing if there are no entries.
void print_times(const char* what, const LatencyHistogram& times);

}  // namespace saltus::robots::walking
