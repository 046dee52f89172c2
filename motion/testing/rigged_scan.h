// A rigged character whose poses are known, as template, target and truth; for tests and
// benchmarks.
#pragma once

#include <optional>
#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/marks.h"

namespace keypose::motion {

struct RiggedScan {
  Mesh target;                   ///< z up
  std::vector<PointsX3> poses;   ///< of the target: the truth
  PointsX3 reference;            ///< of the template: a tenth of the target's vertices
  FacesX3 faces;                 ///< of the template
  std::vector<PointsX3> frames;  ///< of the template
  std::vector<Mark> marks;
};

/// motion/rigs/cheburashka of the data folder, with marks spread over the template. Nothing where
/// the folder is not here (KEYPOSE_DATA tells where it is).
std::optional<RiggedScan> LoadRiggedScan(int marks);

/// Each vertex of the target moves rigidly with the mark nearest to it along the surface.
std::vector<PointsX3> NearestMarkSkinning(const RiggedScan& scan);

/// Distances of vertices from the truth, over the diagonal: mean over vertices and poses, and the
/// largest of the poses' means.
struct PoseError {
  double mean = 0, worst = 0, furthest = 0;
};
PoseError ErrorOf(const RiggedScan& scan, const std::vector<PointsX3>& poses);

/// An arm of radius 0.2 and length 2 along z, marked on both sides of its elbow, and the template's
/// pose with the elbow bent rigidly by an angle [rad].
struct BentArm {
  Mesh arm;
  PointsX3 bent;
  std::vector<Mark> marks;
};
BentArm MakeBentArm(double angle);

/// The face whose centre is nearest to a point.
int FaceNear(const Mesh& mesh, const Eigen::RowVector3d& point);

}  // namespace keypose::motion
