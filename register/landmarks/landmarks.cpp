#include "register/landmarks/landmarks.h"

#include <cmath>
#include <iterator>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "register/landmarks/landmark_doubts.h"
#include "register/nricp/alignment.h"

namespace keypose::registration {

namespace {

constexpr double kSamePlace = 1e-6, kContradicts = 0.02, kOutside = 1e-6;

Eigen::Vector3d CheckedPosition(const std::string& name, int face, const Eigen::Vector3d& b,
                                const Mesh& mesh, const std::string& side) {
  if (face < 0 || face >= mesh.face_count())
    throw InputError("register: landmark '" + name + "' is on face " + std::to_string(face) +
                     ", but the " + side + " has " + std::to_string(mesh.face_count()) +
                     " faces; it was picked on another mesh: pick it again");
  if (!b.allFinite() || std::abs(b.sum() - 1) > kOutside || b.minCoeff() < -kOutside)
    throw InputError("register: landmark '" + name + "' lies off face " + std::to_string(face) +
                     " of the " + side +
                     "; its barycentric coordinates must be 0 or more and sum to 1: pick it again");
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) p += b[k] * mesh.points.row(mesh.faces(face, k)).transpose();
  return p;
}

[[noreturn]] void ThrowContradiction(const LandmarkGoal& a, const LandmarkGoal& b,
                                     const std::string& same, const std::string& other) {
  throw InputError("register: landmarks '" + a.name + "' and '" + b.name +
                   "' are the same point of the " + same + " but different points of the " + other +
                   "; remove one of them");
}

}  // namespace

CheckedLandmarks CheckLandmarks(const std::vector<PickedPair>& pairs, const Mesh& source,
                                const Mesh& target) {
  CheckedLandmarks checked;
  const double source_diagonal = BoundingDiagonal(source.points),
               target_diagonal = BoundingDiagonal(target.points);
  PointsX3 from(std::ssize(pairs), 3);
  for (const PickedPair& pair : pairs) {
    LandmarkGoal goal;
    goal.name = pair.name;
    const Eigen::Vector3d p =
        CheckedPosition(pair.name, pair.source_face, pair.source_barycentric, source, "source");
    goal.target =
        CheckedPosition(pair.name, pair.target_face, pair.target_barycentric, target, "target");
    goal.source.vertices = source.faces.row(pair.source_face).transpose();
    goal.source.weights = pair.source_barycentric;
    bool duplicate = false;
    for (std::size_t k = 0; k < checked.goals.size(); ++k) {
      const double d_source = (from.row(k).transpose() - p).norm() / source_diagonal;
      const double d_target = (checked.goals[k].target - goal.target).norm() / target_diagonal;
      if (d_source <= kSamePlace && d_target > kContradicts)
        ThrowContradiction(checked.goals[k], goal, "source", "target");
      if (d_target <= kSamePlace && d_source > kContradicts)
        ThrowContradiction(checked.goals[k], goal, "target", "source");
      duplicate = duplicate || (d_source <= kSamePlace && d_target <= kSamePlace);
    }
    if (duplicate) {
      ++checked.duplicates;
      continue;
    }
    from.row(checked.goals.size()) = p;
    checked.goals.push_back(goal);
  }
  from.conservativeResize(std::ssize(checked.goals), 3);
  checked.coplanar = from.rows() >= 3 && SpreadRank(from) < 3;
  checked.warnings = WarningsAbout(checked.goals, source, target);
  return checked;
}

}  // namespace keypose::registration
