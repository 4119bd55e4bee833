// A program with `using namespace saltus` may use these names for its own types.
#include <gtest/gtest.h>

#include "saltus/saltus.hpp"

using namespace saltus;

struct Body {};
struct Car {};
struct Contact {};
struct Control {};
struct Controller {};
struct Cost {};
struct Constraint {};
struct Data {};
struct Dynamics {};
struct Foot {};
struct Force {};
struct Gear {};
struct Guard {};
struct Input {};
struct Mode {};
struct Model {};
struct Motion {};
struct Node {};
struct Obstacle {};
struct Options {};
struct Parameters {};
struct Plant {};
struct Point {};
struct Problem {};
struct Reset {};
struct Result {};
struct Road {};
struct Robot {};
struct Settings {};
struct State {};
struct Step {};
struct Target {};
struct Transition {};
struct Weights {};

namespace {

template <class... Own>
constexpr int count = sizeof...(Own);

// The test passes if it compiles: the compiler rejects an ambiguous name where it is used.
TEST(UserNames, AreAvailableToTheUser) {
  EXPECT_EQ((count<Body, Car, Contact, Control, Controller, Cost, Constraint, Data, Dynamics, Foot,
                   Force, Gear, Guard, Input, Mode, Model, Motion, Node, Obstacle, Options,
                   Parameters, Plant, Point, Problem, Reset, Result, Road, Robot, Settings, State,
                   Step, Target, Transition, Weights>),
            34);
}

}  // namespace
