// Tests which settings are accepted. Each kind of mistake gives one sentence and changes nothing.
#include "saltus/app/settings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "saltus/core/error.hpp"
#include "tests/app/support.hpp"

namespace saltus {
namespace {

enum class Plant { centroidal, dart };

struct Config {
  double impulse = 7.0;
  Eigen::Vector3d direction{0.0, -1.0, 0.0};
  std::optional<double> trigger;
  double friction = 0.5;
  double fz_min = 20.0;
  double fz_max = 500.0;
  int intervals = 15;
  bool stepping = true;
  std::string solver = "ipopt";
  Plant plant = Plant::centroidal;
  std::string urdf;

  friend bool operator==(const Config&, const Config&) = default;
};

struct SettingsTest : testing::Test {
  SettingsTest() {
    settings.number("push.impulse", config.impulse, "N s", "size of the push", at_least(0.0));
    settings.choice("solver", config.solver, {"ipopt", "riccati", "sparse"}, "which back-end");
    settings.vector("push.direction", config.direction, "", "direction of the push");
    settings.number("step.trigger", config.trigger, "s", "when to step", at_least(0.0));
    settings.number("contact.friction", config.friction, "", "Coulomb friction", above(0.0));
    settings.number("contact.fz_min", config.fz_min, "N", "smallest normal force");
    settings.number("contact.fz_max", config.fz_max, "N", "largest normal force");
    settings.integer("horizon.intervals", config.intervals, "", "N", at_least(1));
    settings.flag("stepping", config.stepping, "may the robot step?");
    settings.choice<Plant>("plant", config.plant,
                           {{"centroidal", Plant::centroidal}, {"dart", Plant::dart}}, "plant");
    settings.text("robot.urdf", config.urdf, "file of the robot");
    settings.alias("urdf", "robot.urdf");
    settings.rule({"contact.fz_min", "contact.fz_max"}, [this] {
      return config.fz_min <= config.fz_max ? "" : "contact.fz_min exceeds contact.fz_max";
    });
  }

  void set(std::initializer_list<const char*> texts) {
    std::vector<Assignment> assignments;
    for (const char* text : texts) assignments.push_back(parse_set_argument(text));
    settings.apply(assignments);
  }

  // Returns the error message. A mistake must leave the configuration unchanged.
  std::string complaint(const std::function<void()>& action) {
    const Config before = config;
    try {
      action();
    } catch (const InputError& error) {
      EXPECT_TRUE(before == config) << "changed in spite of: " << error.what();
      EXPECT_FALSE(contains(error.what(), "\n"));
      return error.what();
    }
    return "no complaint";
  }
  std::string complaint_about(std::initializer_list<const char*> texts) {
    return complaint([&] { set(texts); });
  }
  std::string complaint_about_file(const std::string& content) {
    const auto file = folder.file("push.yaml", content);
    return complaint([&] { settings.apply(file, {}); });
  }

  TemporaryFolder folder;
  Config config;
  Settings settings;
};

TEST_F(SettingsTest, ReadsEveryKindFromSetArguments) {
  set({"push.impulse=8.5", "push.direction=[0, 1e0, -2]", "step.trigger=0.6", "stepping=false",
       "horizon.intervals=30", "solver=riccati", "plant=dart", "robot.urdf=a=b.urdf"});
  EXPECT_EQ(config.impulse, 8.5);
  EXPECT_EQ(config.direction, Eigen::Vector3d(0.0, 1.0, -2.0));
  EXPECT_EQ(config.trigger, 0.6);
  EXPECT_FALSE(config.stepping);
  EXPECT_EQ(config.intervals, 30);
  EXPECT_EQ(config.solver, "riccati");
  EXPECT_EQ(config.plant, Plant::dart);
  EXPECT_EQ(config.urdf, "a=b.urdf");
  set({"step.trigger=none", "push.direction=3,2,1", "push.impulse=+1"});
  EXPECT_FALSE(config.trigger);
  EXPECT_EQ(config.direction, Eigen::Vector3d(3.0, 2.0, 1.0));
  EXPECT_EQ(config.impulse, 1.0);
}

TEST_F(SettingsTest, CommandLineOverridesTheFile) {
  const auto file = folder.file("push.yaml",
                                "# a comment\n"
                                "push: {impulse: 6, direction: [1, 0, 0]}\n"
                                "contact.friction: 0.4\n"
                                "stepping: false\n"
                                "robot:\n  urdf: \"dir with space/robot: 1.urdf\"\n");
  settings.apply(file, {parse_set_argument("push.impulse=9"), flag_assignment("plant", "dart")});
  EXPECT_EQ(config.impulse, 9.0);
  EXPECT_EQ(config.direction, Eigen::Vector3d(1.0, 0.0, 0.0));
  EXPECT_EQ(config.friction, 0.4);
  EXPECT_FALSE(config.stepping);
  EXPECT_EQ(config.plant, Plant::dart);
  EXPECT_EQ(config.urdf, "dir with space/robot: 1.urdf");
}

TEST_F(SettingsTest, FlagsAbbreviateKeys) {
  settings.apply({flag_assignment("urdf", "r.urdf"), flag_assignment("push.impulse", "-0")});
  EXPECT_EQ(config.urdf, "r.urdf");
  config.stepping = false;
  settings.apply({bare_flag_assignment("stepping")});
  EXPECT_TRUE(config.stepping);
  EXPECT_EQ(complaint([&] { settings.apply({bare_flag_assignment("push.impulse")}); }),
            "--push.impulse: 'push.impulse' must be a number (N s), but has no value");
}

TEST_F(SettingsTest, UnknownNamesSuggestTheNearest) {
  EXPECT_EQ(complaint_about_file("push:\n  impluse: 3\n"),
            (folder / "push.yaml").string() +
                ":2: unknown key 'push.impluse'; did you mean 'push.impulse'?");
  EXPECT_EQ(complaint_about({"impulse=3"}),
            "--set impulse=3: unknown key 'impulse'; did you mean 'push.impulse'?");
  EXPECT_EQ(complaint_about({"xyzzy=3"}),
            "--set xyzzy=3: unknown key 'xyzzy'; --help lists all of them");
  EXPECT_EQ(complaint_about({"push=3"}),
            "--set push=3: 'push' is a section, not a value; it contains push.impulse and "
            "push.direction");
  EXPECT_TRUE(contains(complaint_about({"push.impulse.x=3"}), "did you mean 'push.impulse'?"));
  const auto flag = [&](const char* name) {
    return complaint([&] { settings.apply({flag_assignment(name, "x")}); });
  };
  EXPECT_EQ(flag("plnat"), "unknown flag '--plnat'; did you mean '--plant'?");
  EXPECT_EQ(flag("udf"), "unknown flag '--udf'; did you mean '--urdf'?");
  EXPECT_EQ(flag("cofnig"), "unknown flag '--cofnig'; did you mean '--config'?");
  // An alias is a flag, not a key.
  EXPECT_TRUE(contains(complaint_about({"urdf=x"}), "did you mean 'robot.urdf'?"));
}

TEST_F(SettingsTest, RejectsWrongTypes) {
  EXPECT_EQ(
      complaint_about_file("push:\n  impulse: strong\n"),
      (folder / "push.yaml").string() + ":2: 'push.impulse' must be a number (N s), not 'strong'");
  EXPECT_TRUE(contains(complaint_about({"push.impulse=7N"}), "must be a number"));
  EXPECT_TRUE(contains(complaint_about({"push.impulse=0x10"}), "must be a number"));
  EXPECT_TRUE(contains(complaint_about({"push.impulse="}), "but has no value"));
  EXPECT_TRUE(contains(complaint_about({"push.impulse=[7]"}), "must be a number"));
  EXPECT_TRUE(contains(complaint_about_file("push.impulse:\n"), "but has no value"));
  EXPECT_TRUE(contains(complaint_about_file("push.impulse: [1, 2]\n"), "not '[1, 2]'"));
  EXPECT_TRUE(contains(complaint_about({"horizon.intervals=15.5"}), "must be a whole number"));
  EXPECT_TRUE(contains(complaint_about({"horizon.intervals=3000000000"}), "of at most 2147483647"));
  EXPECT_TRUE(contains(complaint_about({"horizon.intervals=99999999999"}), "must be at least 1"));
  EXPECT_TRUE(contains(complaint_about({"stepping=maybe"}), "must be true or false, not 'maybe'"));
  EXPECT_TRUE(contains(complaint_about({"push.direction=[0, 1]"}), "a list of 3 numbers"));
  EXPECT_TRUE(contains(complaint_about({"push.direction=[0, 1, 2,]"}), "a list of 3 numbers"));
  EXPECT_TRUE(contains(complaint_about({"push.direction=[0, 1, x]"}), "must be a number"));
  EXPECT_TRUE(contains(complaint_about({"push.direction=2"}), "a list of 3 numbers"));
  EXPECT_TRUE(contains(complaint_about_file("robot.urdf: [a]\n"), "must be a text"));
  EXPECT_TRUE(contains(complaint_about_file("push.direction: [[0], 1, 2]\n"), "plain values"));
  EXPECT_EQ(complaint_about({"solver=ricati"}),
            "--set solver=ricati: 'solver' must be ipopt, riccati or sparse, not 'ricati'; did you "
            "mean 'riccati'?");
  EXPECT_TRUE(contains(complaint_about({"plant=3"}), "must be centroidal or dart, not '3'"));
}

TEST_F(SettingsTest, ShortensLongTexts) {
  const std::string digits(1 << 20, '7'), number = "push.impulse=" + digits + "x",
                                          key = digits + "=1";
  EXPECT_TRUE(contains(complaint_about({number.c_str()}), "777... (1048577 bytes)"));
  EXPECT_LT(complaint_about({number.c_str()}).size(), 500u);
  EXPECT_LT(complaint_about({key.c_str()}).size(), 500u);
  EXPECT_LT(complaint_about_file("push.impulse: " + digits + "x\n").size(), 500u);
}

TEST_F(SettingsTest, NumbersMustBeFiniteAndInRange) {
  for (const char* text : {"nan", "NaN", "-nan", ".nan", "inf", "-inf", ".inf", "1e999"}) {
    EXPECT_TRUE(contains(complaint_about({("push.impulse=" + std::string(text)).c_str()}),
                         "must be a finite number"))
        << text;
  }
  EXPECT_TRUE(contains(complaint_about({"push.direction=[0, nan, 0]"}), "finite"));
  EXPECT_EQ(complaint_about({"push.impulse=-1"}),
            "--set push.impulse=-1: 'push.impulse' must be at least 0 N s, not '-1'");
  EXPECT_EQ(complaint_about({"contact.friction=0"}),
            "--set contact.friction=0: 'contact.friction' must be above 0, not '0'");
  EXPECT_TRUE(contains(complaint_about({"horizon.intervals=0"}), "must be at least 1, not '0'"));
  set({"push.impulse=0"});  // a closed end belongs to the range
  EXPECT_EQ(config.impulse, 0.0);
}

TEST_F(SettingsTest, DescribesRanges) {
  EXPECT_EQ(Range(between(0.0, 1.0)).text("m"), "at least 0 and at most 1 m");
  EXPECT_EQ(strictly_between(0.0, 0.5).text(), "above 0 and below 0.5");
  EXPECT_EQ(below(2.0).text(), "below 2");
  EXPECT_EQ(Range().text("m"), "");
  EXPECT_FALSE(Range().contains(std::nan("")));
  EXPECT_FALSE(below(2.0).contains(2.0));
}

TEST_F(SettingsTest, RejectsDuplicates) {
  EXPECT_EQ(complaint_about_file("stepping: true\npush:\n  impulse: 3\npush.impulse: 4\n"),
            (folder / "push.yaml").string() + ":4: key 'push.impulse' was already given at " +
                (folder / "push.yaml").string() + ":3");
  EXPECT_TRUE(contains(complaint_about_file("stepping: true\nstepping: false\n"),
                       ":2: key 'stepping' was already given"));
  EXPECT_EQ(complaint_about({"stepping=true", "stepping=false"}),
            "--set stepping=false: 'stepping' was already given by --set stepping=true");
  EXPECT_TRUE(
      contains(complaint([&] {
                 settings.apply({flag_assignment("urdf", "a"), flag_assignment("robot.urdf", "b")});
               }),
               "already given by --urdf"));
}

TEST_F(SettingsTest, AssignsNothingAfterAMistake) {
  // complaint() checks that the configuration is unchanged.
  EXPECT_TRUE(
      contains(complaint_about({"push.impulse=1", "stepping=false", "push.direction=1,x,3"}),
               "not '1,x,3'"));
  EXPECT_TRUE(contains(complaint_about_file("push.impulse: 1\nsolver: none_such\n"), ":2: "));
  const auto file = folder.file("good.yaml", "push.impulse: 1\n");
  EXPECT_TRUE(contains(complaint([&] { settings.apply(file, {parse_set_argument("plant=moon")}); }),
                       "plant"));
}

TEST_F(SettingsTest, RulesBetweenSettingsRollBack) {
  EXPECT_EQ(complaint_about({"push.impulse=1", "contact.fz_min=600", "solver=sparse"}),
            "--set contact.fz_min=600: contact.fz_min exceeds contact.fz_max");
  set({"contact.fz_min=600", "contact.fz_max=700"});  // both together are valid
  EXPECT_EQ(config.fz_max, 700.0);
}

TEST_F(SettingsTest, RejectsUnusableFiles) {
  EXPECT_EQ(complaint([&] { settings.apply("/nowhere/push.yaml", {}); }),
            "/nowhere/push.yaml: there is no such file");
  EXPECT_TRUE(contains(complaint([&] { settings.apply(folder.path(), {}); }), "is a folder"));
  EXPECT_TRUE(contains(complaint_about_file(""), "is empty"));
  EXPECT_TRUE(contains(complaint_about_file(" \n\n"), "is empty"));
  EXPECT_TRUE(contains(complaint_about_file("# only words\n"), "contains no settings"));
  EXPECT_TRUE(contains(complaint_about_file("{}\n"), "contains no settings"));
  EXPECT_TRUE(contains(complaint_about_file("- a\n- b\n"), ":1: expected 'key: value'"));
  EXPECT_TRUE(contains(complaint_about_file("just words\n"), ":1: expected 'key: value'"));
  EXPECT_TRUE(
      contains(complaint_about_file("stepping: true\npush: {impulse: 3\n"), "not valid YAML"));
  EXPECT_TRUE(contains(complaint_about_file("stepping: true\n\tpush: 3\n"), "not valid YAML"));
  EXPECT_TRUE(contains(complaint_about_file("stepping: true\n---\nstepping: false\n"),
                       "a second YAML document"));
  EXPECT_TRUE(contains(complaint_about_file("[a, b]: 3\n"), "a key must be a name"));
  EXPECT_TRUE(contains(complaint_about_file("push: {}\n"), "'push' is a section"));
  EXPECT_TRUE(contains(complaint_about_file(std::string("\x7f"
                                                        "ELF\x02\x01\0\0\xff\xfe",
                                                        10)),
                       "push.yaml"));
  EXPECT_TRUE(contains(complaint_about_file("a: &x {b: *x}\n"), "push.yaml"));  // refers to itself
  EXPECT_TRUE(contains(complaint([] { parse_set_argument("stepping"); }), "expected KEY=VALUE"));
  EXPECT_TRUE(contains(complaint([] { parse_set_argument("=3"); }), "expected KEY=VALUE"));
}

TEST_F(SettingsTest, WrittenConfigurationReadsBackExactly) {
  set({"push.impulse=0.1", "push.direction=0.3333333333333333,1e-300,-7", "robot.urdf=a \"b\": #c",
       "step.trigger=0.7", "plant=dart", "stepping=false"});
  const Config written = config;
  const auto file = folder.file("effective.yaml", settings.to_yaml());
  config = Config{};
  settings.apply(file, {});
  EXPECT_TRUE(config == written) << settings.to_yaml();
  EXPECT_TRUE(contains(settings.to_yaml(), "push:\n  impulse: 0.1  # N s\n  direction: ["));
  EXPECT_TRUE(contains(settings.to_yaml(), ", 1.0e-300, -7]"));  // for YAML 1.1 readers
}

TEST_F(SettingsTest, DescriptionNamesDefaultUnitRangeAndFlag) {
  set({"push.impulse=3"});  // the defaults are the values at declaration
  const std::string text = settings.describe();
  EXPECT_TRUE(contains(text, "push.impulse=7 N s"));
  EXPECT_TRUE(contains(text, "size of the push (at least 0)"));
  EXPECT_TRUE(contains(text, "solver=ipopt"));
  EXPECT_TRUE(contains(text, "(ipopt, riccati or sparse)"));
  EXPECT_TRUE(contains(text, "[--urdf]"));
  EXPECT_TRUE(contains(text, "step.trigger=none "));
}

TEST_F(SettingsTest, OldKeyWarnsWithTheNewName) {
  settings.renamed("push.size", "push.impulse", "0.4");
  set({"push.size=9"});
  EXPECT_EQ(config.impulse, 9.0);
  EXPECT_EQ(settings.warnings(),
            std::vector<std::string>{"--set push.size=9: 'push.size' is now called 'push.impulse'; "
                                     "the old name is removed in 0.4"});
  set({"push.impulse=8"});
  EXPECT_TRUE(settings.warnings().empty());
  settings.apply({flag_assignment("push.size", "6")});
  EXPECT_EQ(config.impulse, 6.0);
  settings.apply(folder.file("old.yaml", "push:\n  size: 5\n"), {});
  EXPECT_EQ(config.impulse, 5.0);
  EXPECT_TRUE(contains(settings.warnings().at(0), "old.yaml:2: 'push.size' is now called"));
  EXPECT_TRUE(contains(complaint([&] {
                         set({"push.size=1", "push.impulse=2"});
                       }),
                       "'push.impulse' was already given"));
  EXPECT_EQ(config.impulse, 5.0);
  EXPECT_FALSE(contains(settings.describe(), "push.size"));  // no code reads it any more
  double number = 1.0;
  EXPECT_THROW(settings.number("push.size", number, "", ""), DefinitionError);
  EXPECT_THROW(settings.renamed("x", "no.such.key", "0.4"), DefinitionError);
  EXPECT_THROW(settings.renamed("stepping", "push.impulse", "0.4"), DefinitionError);
}

TEST_F(SettingsTest, GivenValuesOverridePresets) {
  std::string name = "soft";
  settings.choice("preset", name, {"soft", "hard"}, "difficulty of the problem");
  settings.preset("preset", {"soft"}, {"push.impulse=7", "stepping=true", "plant=centroidal"});
  settings.preset("preset", {"hard"}, {"push.impulse=9", "stepping=false", "plant=dart"});
  EXPECT_TRUE(contains(settings.describe(), "hard: push.impulse=9, stepping=false, plant=dart"));
  set({"push.impulse=3"});  // no preset is given, so none applies
  EXPECT_EQ(config.impulse, 3.0);
  EXPECT_TRUE(config.stepping);
  set({"stepping=true", "preset=hard"});  // in any order
  EXPECT_EQ(config.impulse, 9.0);
  EXPECT_TRUE(config.stepping);
  EXPECT_EQ(config.plant, Plant::dart);
  settings.apply(folder.file("day.yaml", "push:\n  impulse: 5\n"),
                 {flag_assignment("preset", "hard")});
  EXPECT_EQ(config.impulse, 5.0);
  EXPECT_FALSE(config.stepping);
  const Config written = config;
  const auto file = folder.file("effective.yaml", settings.to_yaml());
  set({"preset=soft"});
  EXPECT_EQ(config.impulse, 7.0);
  settings.apply(file, {});
  EXPECT_TRUE(config == written && name == "hard");
  EXPECT_TRUE(contains(complaint([&] { set({"preset=hart"}); }), "did you mean 'hard'?"));
  EXPECT_THROW(settings.preset("preset", {"soft"}, {"stepping=7"}), InputError);
}

TEST_F(SettingsTest, PresetsDoNotTriggerPresets) {
  std::string name = "soft";
  settings.choice("preset", name, {"soft", "hard"}, "how hard");
  settings.preset("plant", {"dart"}, {"preset=hard", "push.impulse=9"});
  settings.preset("preset", {"soft"}, {"push.impulse=7"});
  settings.preset("preset", {"hard"}, {"push.impulse=8", "stepping=false"});
  set({"stepping=true"});
  EXPECT_EQ(name, "soft");
  set({"plant=centroidal"});
  EXPECT_EQ(name, "soft");
  set({"plant=dart", "preset=soft"});  // the later list wins
  EXPECT_EQ(name, "soft");
  EXPECT_EQ(config.impulse, 7.0);
  set({"plant=dart"});
  EXPECT_EQ(name, "hard");
  EXPECT_EQ(config.impulse, 9.0);
  EXPECT_TRUE(config.stepping);  // the listed value is not looked up again
  set({"plant=dart", "push.impulse=3"});
  EXPECT_EQ(config.impulse, 3.0);
  EXPECT_TRUE(contains(settings.describe(), "; dart: preset=hard, push.impulse=9"));
  EXPECT_THROW(settings.preset("push.impulse", {"2"}, {"preset=hard"}), DefinitionError);
  EXPECT_THROW(settings.preset("plant", {"moon"}, {"preset=hard"}), DefinitionError);
  EXPECT_THROW(settings.preset("plant", {"dart"}, {"no.such.key=1"}), DefinitionError);
  EXPECT_THROW(settings.preset("plant", {"dart"}, {"preset=harder"}), InputError);
}

TEST_F(SettingsTest, AcceptsARemovedKeyWithItsFixedValue) {
  settings.removed("noise.seed", "1", "0.4");
  settings.removed("push.shape", "box", "0.4");
  settings.apply(folder.file("old.yaml", "noise:\n  seed: 1.0\npush:\n  shape: box\n"), {});
  ASSERT_EQ(settings.warnings().size(), 1u);
  EXPECT_TRUE(
      contains(settings.warnings()[0],
               "old.yaml:2: these are no longer settings and have fixed values: noise.seed"));
  EXPECT_TRUE(contains(settings.warnings()[0], "push.shape"));
  EXPECT_TRUE(contains(complaint([&] { set({"noise.seed=2"}); }),
                       "'noise.seed' is no longer a setting, its value is always 1; remove it"));
  EXPECT_TRUE(contains(complaint([&] { set({"push.shape=[1, 2]"}); }), "remove it"));
  EXPECT_THROW(settings.removed("stepping", "1", "0.4"), DefinitionError);
  EXPECT_TRUE(nlohmann::json::parse(settings.json_schema("push"))
                  .at("properties")
                  .at("noise")
                  .at("properties")
                  .at("seed")
                  .at("deprecated"));
}

TEST_F(SettingsTest, TranslatesOldAssignments) {
  settings.translate([](std::vector<Assignment>& file, std::vector<Assignment>& command_line) {
    EXPECT_TRUE(command_line.empty());
    for (Assignment& a : file)
      if (a.key == "force") a.key = "push.impulse";
    return std::vector<std::string>{"old"};
  });
  settings.apply(folder.file("old.yaml", "force: 4\n"), {});
  EXPECT_EQ(config.impulse, 4.0);
  EXPECT_EQ(settings.warnings(), std::vector<std::string>{"old"});
}

TEST_F(SettingsTest, RejectsWrongDeclarations) {
  double number = -1.0;
  std::string name = "c";
  EXPECT_THROW(settings.number("stepping", number, "", ""), DefinitionError);
  EXPECT_THROW(settings.number("push", number, "", ""), DefinitionError);
  EXPECT_THROW(settings.number("stepping.x", number, "", ""), DefinitionError);
  EXPECT_THROW(settings.number("positive", number, "", "", above(0.0)), DefinitionError);
  EXPECT_THROW(settings.choice("letter", name, {"a", "b"}, ""), DefinitionError);
  EXPECT_THROW(settings.alias("x", "no.such.key"), DefinitionError);
  EXPECT_THROW(settings.alias("plant", "solver"), DefinitionError);
  EXPECT_THROW(settings.rule({"no.such.key"}, [] { return std::string(); }), DefinitionError);
}

TEST_F(SettingsTest, ReadsItsDocumentedYaml) {
  set({"push.impulse=0.1", "plant=dart", "robot.urdf=a # b.urdf", "step.trigger=0.25"});
  const Config changed = config;
  const std::string text = settings.to_documented_yaml();
  EXPECT_TRUE(
      contains(text, "  # size of the push [N s; at least 0; default 7]\n  impulse: 0.1\n"));
  EXPECT_TRUE(contains(text, "# plant [centroidal or dart; default centroidal]\nplant: dart\n"));
  set({"push.impulse=3", "plant=centroidal", "robot.urdf=", "step.trigger=none"});
  settings.apply(folder.file("printed.yaml", text), {});
  EXPECT_EQ(config, changed);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    EXPECT_LE(end - begin, 100u);
    begin = end + 1;
  }
}

TEST_F(SettingsTest, SchemaHasTheAllowedValues) {
  settings.renamed("friction", "contact.friction", "0.3");
  const nlohmann::json schema = nlohmann::json::parse(settings.json_schema("push"));
  const auto property = [&](const char* pointer) {
    return schema.at(nlohmann::json::json_pointer(pointer));
  };
  EXPECT_EQ(property("/properties/push/properties/impulse/minimum"), 0.0);
  EXPECT_EQ(property("/properties/push/properties/impulse/default"), 7.0);
  EXPECT_EQ(property("/properties/contact/properties/friction/exclusiveMinimum"), 0.0);
  EXPECT_EQ(property("/properties/contact/additionalProperties"), false);
  EXPECT_EQ(property("/properties/horizon/properties/intervals/type"), "integer");
  EXPECT_EQ(property("/properties/plant/enum"), (nlohmann::json{"centroidal", "dart"}));
  EXPECT_EQ(property("/properties/push/properties/direction/maxItems"), 3);
  EXPECT_EQ(property("/properties/step/properties/trigger/anyOf").size(), 2u);
  EXPECT_EQ(property("/properties/friction/deprecated"), true);
}

TEST_F(SettingsTest, ListsValuesForCompletion) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(settings.values_of("plant"), (Words{"centroidal", "dart"}));
  EXPECT_EQ(settings.values_of("stepping"), (Words{"true", "false"}));
  EXPECT_EQ(settings.values_of("push.impulse"), Words{});
  EXPECT_EQ(settings.values_of("nothing"), Words{});
  EXPECT_EQ(settings.flags().back(), "urdf");
}

}  // namespace
}  // namespace saltus
