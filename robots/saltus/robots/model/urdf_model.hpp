// What does a URDF say about a robot's masses, frames and feet?
//
// Read through urdfdom, checked once, kept as plain data: links in an order in which every parent
// comes before its children, each with its joint to the parent. Units: m, kg, rad.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// Joint name -> position (rad, or m for a prismatic joint). Joints that are not named are at zero.
using Posture = std::map<std::string, double>;

/// A joint of a URDF.
struct UrdfJoint {
  enum class Motion { fixed, revolute, prismatic };  // revolute: continuous joints too

  std::string name;               // empty for the root link, which has no joint
  Motion motion = Motion::fixed;  ///< what moves
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // joint frame in the parent link
  Vec<double, 3> axis = Vec<double, 3>::UnitX();             // unit, in the joint frame
  Bounds position;                                           // rad or m
  double effort = infinity;                                  // Nm or N
  double velocity = infinity;                                // rad/s or m/s; 0 in a file: none
};

/// A box of a URDF.
struct UrdfBox {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // of its centre, in the link
  Vec<double, 3> size = Vec<double, 3>::Zero();            // edge lengths, m
};

/// A shape of a link: what it looks like, or what of it collides.
struct UrdfShape {
  /// Which kind of shape.
  enum class Shape { mesh, box, cylinder, sphere };

  Shape shape = Shape::box;                                ///< which kind
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // in the link
  std::string mesh;                                        // file as the URDF writes it, or empty
  /// Mesh: scale; box: edge lengths; cylinder, along z: diameter, diameter, length; sphere:
  /// diameters. m
  Vec<double, 3> size = Vec<double, 3>::Ones();
  Vec<double, 3> colour = Vec<double, 3>::Constant(0.9);  // red, green, blue, 0 to 1
};

/// A link of a URDF.
struct UrdfLink {
  std::string name;                             ///< as in the file
  int parent = -1;                              // index of the parent link, -1 for the root
  UrdfJoint joint;                              // from the parent
  double mass = 0.0;                            ///< kg
  Vec<double, 3> com = Vec<double, 3>::Zero();  // in the link frame
  Mat<double, 3, 3> inertia = Mat<double, 3, 3>::Zero();  // about the CoM, in link axes, kg m^2
  std::vector<UrdfBox> collision_boxes;                   // of the shapes below, the boxes
  std::vector<UrdfShape> collisions;                      // colours have no meaning here
  std::vector<UrdfShape> visuals;                         ///< what is drawn
};

/// Of each link the first of those that are fixed to each other and to it, by index.
std::vector<int> rigid_leaders(const std::vector<UrdfLink>& links);

/// The flat underside of a foot: the contact frame is the sole link's frame moved along its z axis
/// by `contact_plane_offset` (m, negative when the plane lies below the origin).
struct FootGeometry {
  FootRectangle rectangle;            // in the contact frame
  double contact_plane_offset = 0.0;  ///< of the sole below its link's origin, m
};

/// A robot's URDF: links, joints, shapes.
class UrdfModel {
 public:
  /// Throws InputError, one sentence naming file and element, when the file is missing, empty, not
  /// well-formed or not a URDF, when its joints form a cycle, when the total mass is zero, and when
  /// a link's mass is negative or its inertia is not that of a body (not positive, or a principal
  /// moment above the sum of the other two). A link without inertial element is a massless frame;
  /// one with mass but without inertia is a point that must be fixed to a body.
  static UrdfModel read(const std::filesystem::path& file);
  /// The same from text; `source` stands for the file in messages.
  static UrdfModel parse(const std::string& text, const std::string& source);

  /// Of the robot.
  const std::string& name() const { return name_; }
  /// File that it was read from.
  const std::string& source() const { return source_; }
  /// In the order of the file.
  const std::vector<UrdfLink>& links() const { return links_; }
  /// In the order of the file.
  std::vector<std::string> link_names() const;
  /// Those that are not fixed, in the order of the file.
  std::vector<std::string> moving_joint_names() const;
  /// Of all links, kg.
  double total_mass() const { return total_mass_; }

  /// Index into links(). Throws InputError that suggests the nearest name.
  int link_index(const std::string& link) const;

  /// Pose of every link in the frame of the root link (forward kinematics). Throws InputError for a
  /// joint that does not exist or cannot move, and a position that is not finite.
  std::vector<Eigen::Isometry3d> link_poses(const Posture& posture) const;
  /// Pose of `link` in the frame of `reference`.
  Eigen::Isometry3d link_pose(const std::string& link, const std::string& reference,
                              const Posture& posture) const;

  /// Centre of mass in the frame of `reference` (m).
  Vec<double, 3> centre_of_mass(const std::string& reference, const Posture& posture) const;

  /// Indices of the links that are fixed to this one, itself included.
  std::vector<int> rigid_group(int link) const;

  /// Whether a link rigidly attached to this one has a collision box.
  bool has_collision_box(const std::string& link) const;

  /// The foot that carries the frame `sole_link`: the lowest faces, in the direction of -z of that
  /// frame, of the collision boxes rigidly attached to it (through fixed joints), as one rectangle
  /// around them. Throws InputError when there is no such box or its edges are not parallel to the
  /// axes of the frame.
  FootGeometry foot(const std::string& sole_link) const;

 private:
  std::string name_;
  std::string source_;
  std::vector<UrdfLink> links_;
  double total_mass_ = 0.0;
};

}  // namespace saltus
