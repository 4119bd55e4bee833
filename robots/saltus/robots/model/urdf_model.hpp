// URDF model: masses, frames, joints and feet of a robot.
//
// Read through urdfdom, checked once, kept as plain data. Each link holds the joint to its parent.
// Links are in the order of the tree, depth first: every parent precedes its children, and urdfdom
// sorts the children of a link by the names of their joints. Units: m, kg, rad.
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

namespace saltus::robots {

/// Map from joint name to position (rad, or m for a prismatic joint). Joints that are not named are
/// at zero.
using Posture = std::map<std::string, double>;

/// Links, joints and shapes of the URDF of a robot.
class UrdfModel {
 public:
  /// A joint of a URDF.
  struct Joint {
    enum class Motion { fixed, revolute, prismatic };  // revolute includes continuous joints

    std::string name;               // empty for the root link, which has no joint
    Motion motion = Motion::fixed;  ///< type of motion
    Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // joint frame in the parent link
    Vec<double, 3> axis = Vec<double, 3>::UnitX();             // unit, in the joint frame
    Bounds position;                                           // rad or m
    double effort = infinity;                                  // Nm or N
    double velocity = infinity;  // rad/s or m/s; 0 in a file means no limit
    std::string leader;          // joint that this one follows by <mimic>; empty if it is free
  };

  /// A box of a URDF.
  struct Box {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // pose of the centre, in the link
    Vec<double, 3> size = Vec<double, 3>::Zero();            // edge lengths, m
  };

  /// A visual or collision shape of a link.
  struct LinkShape {
    /// Type of shape.
    enum class Shape { mesh, box, cylinder, sphere };

    Shape shape = Shape::box;                                ///< type of shape
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // in the link
    std::string mesh;  // path as written in the URDF; empty if no mesh
    /// Mesh: scale factors. Box: edge lengths, m. Cylinder along z: diameter, diameter, length, m.
    /// Sphere: diameters, m.
    Vec<double, 3> size = Vec<double, 3>::Ones();
    Vec<double, 3> colour = Vec<double, 3>::Constant(0.9);  // red, green, blue, 0 to 1
  };

  /// A link of a URDF.
  struct Link {
    std::string name;                             ///< name in the file
    int parent = -1;                              // index of the parent link, -1 for the root
    Joint joint;                                  // joint to the parent
    double mass = 0.0;                            ///< kg
    Vec<double, 3> com = Vec<double, 3>::Zero();  // in the link frame
    Mat<double, 3, 3> inertia = Mat<double, 3, 3>::Zero();  // about the CoM, in link axes, kg m^2
    std::vector<Box> collision_boxes;                       // the boxes among `collisions`
    std::vector<LinkShape> collisions;  // collision shapes; their colours have no meaning
    std::vector<LinkShape> visuals;     ///< shapes that are drawn
  };

  /// The flat underside of a foot. The contact frame is the sole link's frame moved along its z
  /// axis by `contact_plane_offset` (m, negative if the plane lies below the origin).
  struct Foot {
    FootRectangle rectangle;  // in the contact frame
    double contact_plane_offset =
        0.0;  ///< position of the contact plane along z of the sole link, m
  };

  /// Reads and checks a URDF. Throws InputError, one sentence naming file and element, if
  /// - the file is missing, empty, not well-formed or not a URDF;
  /// - its joints form a cycle;
  /// - the total mass is zero;
  /// - a link has a negative mass, or an inertia that no body has (not positive, or a principal
  ///   moment above the sum of the other two).
  /// A link without inertial element is a massless frame. A link with mass but without inertia is a
  /// point mass that must be fixed to a body.
  static UrdfModel read(const std::filesystem::path& file);
  /// Like read(), from text. `source` names the file in messages.
  static UrdfModel parse(const std::string& text, const std::string& source);

  /// Name of the robot.
  const std::string& name() const { return name_; }
  /// File that the model was read from.
  const std::string& source() const { return source_; }
  /// Links, in the order of the tree (not of the file).
  const std::vector<Link>& links() const { return links_; }
  /// Names of all links, in the order of links().
  std::vector<std::string> link_names() const;
  /// Names of the joints that are not fixed, in the order of links().
  std::vector<std::string> moving_joint_names() const;
  /// Total mass of all links, kg.
  double total_mass() const { return total_mass_; }

  /// Index into links(). Throws InputError that suggests the nearest name.
  int link_index(const std::string& link) const;

  /// Pose of every link in the frame of the root link (forward kinematics). Throws InputError if a
  /// joint does not exist or cannot move, or if a position is not finite.
  std::vector<Eigen::Isometry3d> link_poses(const Posture& posture) const;
  /// Pose of `link` in the frame of `reference`.
  Eigen::Isometry3d link_pose(const std::string& link, const std::string& reference,
                              const Posture& posture) const;

  /// Centre of mass in the frame of `reference` (m).
  Vec<double, 3> centre_of_mass(const std::string& reference, const Posture& posture) const;

  /// Indices of the links that are fixed to `link`, itself included.
  std::vector<int> rigid_group(int link) const;

  /// True if a link rigidly attached to this one has a collision box.
  bool has_collision_box(const std::string& link) const;

  /// The foot that carries the frame `sole_link`. Its rectangle bounds the lowest faces, in the
  /// direction of -z of that frame, of the collision boxes rigidly attached to it. Rotated boxes
  /// that are not lower, such as bevelled toes, have no effect. Throws InputError if there is no
  /// box, or if the edges of the lowest one are not parallel to the axes of the frame.
  Foot foot(const std::string& sole_link) const;

 private:
  std::string name_;
  std::string source_;
  std::vector<Link> links_;
  double total_mass_ = 0.0;
};

/// Smallest index among the links fixed to each link, itself included.
std::vector<int> rigid_leaders(const std::vector<UrdfModel::Link>& links);

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using UrdfModel [[deprecated("use robots::UrdfModel; removed in 0.4")]] = robots::UrdfModel;
/// Deprecated name.
using Posture [[deprecated("use robots::Posture; removed in 0.4")]] = robots::Posture;
/// Deprecated name.
using UrdfJoint [[deprecated("use robots::UrdfModel::Joint; removed in 0.4")]] =
    robots::UrdfModel::Joint;
/// Deprecated name.
using UrdfBox [[deprecated("use robots::UrdfModel::Box; removed in 0.4")]] = robots::UrdfModel::Box;
/// Deprecated name.
using UrdfLink [[deprecated("use robots::UrdfModel::Link; removed in 0.4")]] =
    robots::UrdfModel::Link;
/// Deprecated name.
using FootGeometry [[deprecated("use robots::UrdfModel::Foot; removed in 0.4")]] =
    robots::UrdfModel::Foot;
}  // namespace saltus
