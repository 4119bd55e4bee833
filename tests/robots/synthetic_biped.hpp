// A biped that is not iCub, written as text: other names, other mass, boxes only.
//
// 47 kg, twelve joints in the legs and two in the trunk, every link a box. The left leg is slightly
// bent and leans so that the pelvis is above its sole. The right leg is bent more, so that its foot
// is lifted.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus {

struct SyntheticBiped {
  bool feet_have_boxes = true;  // as collision shapes
  std::string left_sole = "sole of left foot";
  double knee_upper = 2.4;  // rad

  static constexpr double thigh = 0.32, shin = 0.32;        // lengths, m
  static constexpr double hip = 0.09, ankle_height = 0.08;  // m
  static constexpr double sole_offset = -0.01;              // m, of the contact plane
  static constexpr double foot_length = 0.20, foot_width = 0.10, foot_forward = 0.03;  // m

  std::string urdf() const {
    std::string text = "<robot name=\"synthetic biped\">\n";
    text += link("pelvis", 8.0, {0.16, 0.20, 0.12}, {0, 0, 0.02});
    text += link("waist", 0.5, {0.06, 0.06, 0.06}, {0, 0, 0});
    text += link("trunk", 20.0, {0.18, 0.30, 0.40}, {0, 0, 0.20});
    text += joint("bend forward", "pelvis", "waist", {0, 0, 0.10}, {0, 1, 0}, -0.5, 1.0, 120.0);
    text += joint("bend sideways", "waist", "trunk", {0, 0, 0.03}, {1, 0, 0}, -0.6, 0.6, 120.0);
    for (const bool is_left : {true, false}) text += leg(is_left);
    return text + "</robot>\n";
  }

  /// Its configuration file, with `more` appended.
  std::string yaml(const std::string& more = "") const {
    // Legs of length l cos(bend), hips and ankles turned by `lean`, the pelvis level.
    const double bend = 0.30, reach = (thigh + shin) * std::cos(bend);
    const double lean = std::asin(hip / reach);
    constexpr double lift = 0.01;  // m, of the right foot
    const double swing = std::acos((reach * std::cos(lean) - lift) / (thigh + shin));
    return fmt::format(
        "name: synthetic\nsource: made up\n"
        "soles: {{left: {}, right: sole of right foot}}\n{}"
        "base: pelvis\njoints:\n"
        "  bend forward: {{}}\n  bend sideways: {{}}\n{}{}"
        "postures:\n  one foot:\n    stance: left\n    joints:\n"
        "      hip roll of left leg: {:.6f}\n      hip pitch of left leg: {:.6f}\n"
        "      knee of left leg: {:.6f}\n      ankle pitch of left leg: {:.6f}\n"
        "      ankle roll of left leg: {:.6f}\n"
        "      hip pitch of right leg: {:.6f}\n      knee of right leg: {:.6f}\n"
        "      ankle pitch of right leg: {:.6f}\n{}",
        left_sole, feet_have_boxes ? "" : feet(), leg_joints("left"), leg_joints("right"), -lean,
        -bend, 2.0 * bend, -bend, lean, -swing, 2.0 * swing, -swing, more);
  }

 private:
  using Vec3 = Vec<double, 3>;

  static std::string feet() {
    const double back = foot_forward - 0.5 * foot_length, front = foot_forward + 0.5 * foot_length;
    const std::string foot = fmt::format("{{x: [{:.4f}, {:.4f}], y: [{:.4f}, {:.4f}]}}", back,
                                         front, -0.5 * foot_width, 0.5 * foot_width);
    return fmt::format("contact_plane_offset: {}\nleft_foot: {}\nright_foot: {}\n", sole_offset,
                       foot, foot);
  }

  static std::string leg_joints(const std::string& side) {
    std::string text;
    for (const char* joint :
         {"hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"})
      text += fmt::format("  {} of {} leg: {{}}\n", joint, side);
    return text;
  }

  // A link with the inertia and the visual of a homogeneous box.
  static std::string link(const std::string& name, double mass, const Vec3& size,
                          const Vec3& centre, const std::string& more = "") {
    const Vec3 s = size.cwiseProduct(size) * mass / 12.0;
    const std::string origin =
        fmt::format("<origin xyz=\"{} {} {}\"/>", centre[0], centre[1], centre[2]);
    return fmt::format(
        "<link name=\"{}\"><inertial>{}<mass value=\"{}\"/><inertia ixx=\"{}\" iyy=\"{}\" "
        "izz=\"{}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\n<visual>{}<geometry>"
        "<box size=\"{} {} {}\"/></geometry></visual>{}</link>\n",
        name, origin, mass, s[1] + s[2], s[0] + s[2], s[0] + s[1], origin, size[0], size[1],
        size[2], more);
  }

  static std::string joint(const std::string& name, const std::string& parent,
                           const std::string& child, const Vec3& place, const Vec3& axis,
                           double lower, double upper, double effort) {
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>"
        "<origin xyz=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>"
        "<limit lower=\"{}\" upper=\"{}\" effort=\"{}\" velocity=\"10\"/></joint>\n",
        name, effort > 0.0 ? "revolute" : "fixed", parent, child, place[0], place[1], place[2],
        axis[0], axis[1], axis[2], lower, upper, effort);
  }

  std::string leg(bool is_left) const {
    const std::string side = is_left ? "left" : "right";
    const auto part = [&side](const char* name) { return fmt::format("{} of {} leg", name, side); };
    const std::string foot = "foot " + side;
    const std::string sole = is_left ? left_sole : "sole of right foot";
    constexpr double foot_height = 0.03;  // m
    const Vec3 foot_centre(foot_forward, 0.0, -ankle_height + 0.5 * foot_height);
    const std::string collision =
        feet_have_boxes
            ? fmt::format(
                  "<collision><origin xyz=\"{} 0 {}\"/><geometry><box size=\"{} {} {}\"/>"
                  "</geometry></collision>",
                  foot_centre[0], foot_centre[2], foot_length, foot_width, foot_height)
            : "";
    std::string text;
    text += link(part("link1"), 0.5, {0.06, 0.06, 0.06}, {0, 0, 0});
    text += link(part("link2"), 0.5, {0.06, 0.06, 0.06}, {0, 0, 0});
    text += link(part("thigh"), 4.0, {0.10, 0.10, thigh}, {0, 0, -0.5 * thigh});
    text += link(part("shin"), 3.0, {0.08, 0.08, shin}, {0, 0, -0.5 * shin});
    text += link(part("link5"), 0.3, {0.05, 0.05, 0.05}, {0, 0, 0});
    text += link(foot, 1.0, {foot_length, foot_width, foot_height}, foot_centre, collision);
    text += fmt::format("<link name=\"{}\"/>\n", sole);
    const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), none(0, 0, 0);
    text += joint(part("hip yaw"), "pelvis", part("link1"), {0, is_left ? hip : -hip, 0}, z, -1.0,
                  1.0, 80.0);
    text += joint(part("hip roll"), part("link1"), part("link2"), none, x, -0.8, 0.8, 120.0);
    text += joint(part("hip pitch"), part("link2"), part("thigh"), none, y, -1.8, 1.0, 120.0);
    text +=
        joint(part("knee"), part("thigh"), part("shin"), {0, 0, -thigh}, y, 0.0, knee_upper, 120.0);
    text +=
        joint(part("ankle pitch"), part("shin"), part("link5"), {0, 0, -shin}, y, -1.2, 0.8, 100.0);
    text += joint(part("ankle roll"), part("link5"), foot, none, x, -0.6, 0.6, 100.0);
    return text + joint("to the " + sole, foot, sole, {0, 0, -ankle_height - sole_offset}, x, 0.0,
                        0.0, 0.0);
  }
};

}  // namespace saltus
