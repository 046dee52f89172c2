// Marks: triangles of a moving template, each with its triangle on the mesh that shall move alike.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

/// A point of a triangle.
struct MarkPlace {
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Constant(1.0 / 3);
};

struct Mark {
  std::string name;
  MarkPlace on_template, on_target;
};

Eigen::RowVector3d PositionOf(const MarkPlace& place, const PointsX3& points, const FacesX3& faces);

/// @throws InputError  no marks, or a mark on a triangle without area (in the template's reference
/// or in the target); names the mark, the triangle and the mesh
void RequireMarks(const std::vector<Mark>& marks, const PointsX3& reference,
                  const FacesX3& template_faces, const Mesh& target);

/// Whether a triangle's doubled area is below 1e-6 of its longest edge squared.
bool HasNoArea(const PointsX3& points, const FacesX3& faces, int face);

/// The map of a triangle from one pose to another, split into a rotation and a stretch before it.
struct TriangleMap {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< with w >= 0
  /// logarithm of the stretch, symmetric, zero along the triangle's normal
  Eigen::Matrix3d log_stretch = Eigen::Matrix3d::Zero();
};

/// @pre both triangles have an area
TriangleMap MapOfTriangle(const PointsX3& from, const PointsX3& to, const FacesX3& faces, int face);

/// The marks of one frame of the template: where they are, and how they turned since the reference.
struct MarkPose {
  PointsX3 positions;             ///< M x 3
  std::vector<TriangleMap> maps;  ///< M
};

/// Measures frames of a template at its marks.
class MarkMeter {
 public:
  /// The arguments must outlive this.
  MarkMeter(const std::vector<Mark>& marks, const PointsX3& reference, const FacesX3& faces)
      : marks_(marks), reference_(reference), faces_(faces) {}
  /// @param name  of the frame, for messages
  /// @throws InputError  a mark's triangle has no area in this frame
  MarkPose Measure(const PointsX3& frame, const std::string& name) const;

 private:
  const std::vector<Mark>& marks_;
  const PointsX3& reference_;
  const FacesX3& faces_;
};

/// How the target lies in its reference pose, relative to the template in its own: the best
/// similarity of the marks' positions.
struct Alignment {
  Eigen::Matrix3d target_from_template = Eigen::Matrix3d::Identity();
  double scale = 1;      ///< of the target, over the template
  double tilt = 0;       ///< angle between the two meshes' upward axes z [rad]
  double heading = 0;    ///< angle about z [rad], in (-pi, pi]
  double residual = 0;   ///< root mean square, over the spread of the target's marks
  double mirrored = 1;   ///< the same of the best mirrored similarity
  bool certain = false;  ///< three marks or more, not in one line
};

/// @param on_template, on_target  M x 3, positions of the marks in the reference poses
Alignment AlignMarks(const PointsX3& on_template, const PointsX3& on_target);

}  // namespace keypose::motion
