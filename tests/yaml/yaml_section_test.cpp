// Reading of YAML files, and one error sentence for each mistake.
#include "saltus/yaml/yaml_section.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "saltus/core/error.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

const std::string sample = R"(# a robot
name: Robo
empty:
feet: {x: [-1, 2.5e-1], names: [left, right]}
postures:
  stand: {}
  walk: {speed: 0.5}
)";

std::string complaint(const std::function<void()>& action) {
  return error_of<InputError>(action, "no complaint");
}

std::string complaint_of(const std::string& text) {
  return complaint([&] { parse_yaml(text, "f"); });
}

TEST(Yaml, ReadsSectionsListsAndLines) {
  const YamlEntry root = parse_yaml(sample, "f");
  ASSERT_EQ(root.entries.size(), 4u);
  EXPECT_EQ(root.entries[0].line, 2);
  EXPECT_EQ(root.entries[1].form, YamlEntry::Form::none);
  const YamlSection file(root, "f");
  EXPECT_EQ(file.text("name"), "Robo");
  const YamlSection feet = file.section("feet");
  EXPECT_EQ(feet.range("x"), between(-1.0, 0.25));
  EXPECT_EQ(feet.numbers<2>("x")[1], 0.25);
  EXPECT_EQ(feet.texts("names"), (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(file.section("postures").keys(), (std::vector<std::string>{"stand", "walk"}));
  EXPECT_TRUE(file.section("postures").section("stand").keys().empty());
  EXPECT_EQ(file.section("postures").section("walk").number("speed"), 0.5);
  EXPECT_TRUE(parse_yaml("# only words\n", "f").entries.empty());
}

TEST(Yaml, ErrorsNameTheKeyPath) {
  const YamlEntry root = parse_yaml(sample, "f");
  const YamlSection file(root, "f"), walk = file.section("postures").section("walk");
  EXPECT_EQ(complaint([&] { walk.allow_only({"sped"}); }),
            "f: postures.walk.speed is not a known key; did you mean \"sped\"?");
  EXPECT_EQ(complaint([&] { walk.number("step"); }), "f: postures.walk.step is missing; add it");
  EXPECT_EQ(complaint([&] { file.number("name"); }), "f: name must be a number, not \"Robo\"");
  EXPECT_EQ(complaint([&] { file.section("name"); }), "f: name must be a set of keys with values");
  EXPECT_EQ(complaint([&] { file.section("feet").numbers<3>("x"); }),
            "f: feet.x must be a list of 3 numbers");
  EXPECT_EQ(complaint([&] { file.section("feet").numbers<2>("names"); }),
            "f: feet.names must be a number, not \"left\"");
  EXPECT_EQ(complaint([&] { file.text("empty"); }), "f: empty must be a text");
}

TEST(Yaml, RejectsNonMappings) {
  EXPECT_EQ(complaint_of(" \n"), "f: the file is empty");
  EXPECT_EQ(complaint_of("a: 1\nb: {c: 2}\na: 3\n"), "f:3: key 'a' was already given at f:1");
  EXPECT_EQ(complaint_of("b: {c: 2}\nb.c: 3\n"), "f:2: key 'b.c' was already given at f:1");
  EXPECT_EQ(complaint_of("b: {c: 2}\nb: {d: 3}\n"), "f:2: key 'b' was already given at f:1");
  EXPECT_EQ(complaint_of("a: [[1]]\n"), "f:1: 'a' must be a list of plain values");
  EXPECT_EQ(complaint_of("a: &x {b: *x}\n"),
            "f:1: aliases (*name) are not supported; write the value out");
  EXPECT_EQ(complaint_of("a: " + std::string(100000, '[')), "f:1: sections are nested too deeply");
  // yaml-cpp reads these as documents without end.
  EXPECT_EQ(complaint_of(", 2]\n"), "f:1: not valid YAML: a value cannot begin like this");
  EXPECT_EQ(complaint_of("? [a, b]\n: 3\n"), "f:1: a key must be a name");
  EXPECT_EQ(complaint_of("a: 1\n---\nb: 2\n"),
            "f:2: a second YAML document begins here; only one is allowed");
  EXPECT_EQ(complaint([] { read_yaml("/nowhere/f.yaml"); }),
            "/nowhere/f.yaml: there is no such file");
  EXPECT_EQ(complaint([] { read_yaml("/"); }), "/: this is a folder, not a file");
}

}  // namespace
}  // namespace saltus
