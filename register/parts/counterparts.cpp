// The second half of parts.h: loose parts are laid onto those of the target.
#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/geometry.h"
#include "core/values/camera.h"
#include "core/values/tuned.h"
#include "register/parts/part_points.h"
#include "register/parts/parts.h"

namespace keypose::registration {

namespace {

using Eigen::Vector3d;
constexpr int kCounterpartFeet = 400;  // vertices of a part fitted to its counterpart

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct CounterpartTuning {
  KEYPOSE_TUNED(int, kCounterpartRounds, 30);       // ICP rounds of the fit to the counterpart
  KEYPOSE_TUNED(double, kCounterpartGrowth, 1.25);  // largest change of scale in this fit
  KEYPOSE_TUNED(double, kSizeAlike, 1.4);           // largest ratio of the sizes of counterparts
  KEYPOSE_TUNED(double, kCentreReach, 0.75);  // of the part's size: largest distance of centres
  KEYPOSE_TUNED(double, kFacing, 0.5);        // cosine: least between the normals of matched points
  KEYPOSE_TUNED(double, kToPoint, 0.3);       // share of the way along the plane that is made
  KEYPOSE_TUNED(double, kHold, 0.02);  // weight of the orientation so far; the landmarks' is 1
};

/// The centre of each part, weighted by area.
std::vector<Vector3d> Centres(const LooseParts& parts, const PointsX3& points,
                              const FacesX3& faces) {
  std::vector<int> part_of(static_cast<std::size_t>(points.rows()), -1);
  for (std::size_t i = 0; i < parts.parts.size(); ++i)
    for (int v : parts.parts[i].vertices) part_of[v] = static_cast<int>(i);
  std::vector<Vector3d> centre(parts.parts.size(), Vector3d::Zero());
  std::vector<double> area(parts.parts.size(), 0);
  const Eigen::VectorXd areas = FaceAreas(points, faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int i = part_of[faces(f, 0)];
    if (i < 0) continue;
    centre[i] +=
        areas[f] *
        (points.row(faces(f, 0)) + points.row(faces(f, 1)) + points.row(faces(f, 2))).transpose() /
        3;
    area[i] += areas[f];
  }
  for (std::size_t i = 0; i < centre.size(); ++i)
    centre[i] = area[i] > 0 ? (centre[i] / area[i]).eval()
                            : points.row(parts.parts[i].vertices[0]).transpose().eval();
  return centre;
}

int NearestCentre(const Vector3d& p, const std::vector<Vector3d>& centres) {
  int best = -1;
  for (std::size_t i = 0; i < centres.size(); ++i)
    if (best < 0 || (centres[i] - p).squaredNorm() < (centres[best] - p).squaredNorm())
      best = static_cast<int>(i);
  return best;
}

/// Finds the motion of a part onto its own landmarks.
/// @return false when it has none
bool OntoLandmarks(const LoosePart& part, const PointsX3& points,
                   const std::vector<LandmarkGoal>& landmarks, Similarity3& motion) {
  std::vector<Vector3d> from, to;
  for (const LandmarkGoal& goal : landmarks) {
    Eigen::Index corner = 0;
    goal.source.weights.maxCoeff(&corner);
    if (!std::binary_search(part.vertices.begin(), part.vertices.end(),
                            goal.source.vertices[corner]))
      continue;
    from.push_back(PositionOf(goal.source, points));
    to.push_back(goal.target);
  }
  if (from.empty()) return false;
  motion = {};
  if (from.size() == 1) {
    motion.translation = to[0] - from[0];
    return true;
  }
  // The part's current orientation has a small weight. It decides the rotation that two landmarks
  // leave open.
  const std::vector<int> some = SomeOf(part.vertices, kFeet);
  const auto marks = std::ssize(from), rest = std::ssize(some);
  PointsX3 a(marks + rest, 3), b(marks + rest, 3);
  Eigen::VectorXd weights(marks + rest);
  Vector3d shift = Vector3d::Zero();
  for (Eigen::Index i = 0; i < marks; ++i) {
    a.row(i) = from[i].transpose();
    b.row(i) = to[i].transpose();
    shift += (to[i] - from[i]) / static_cast<double>(marks);
  }
  a.bottomRows(rest) = RowsOf(points, some);
  b.bottomRows(rest) = a.bottomRows(rest).rowwise() + shift.transpose();
  weights.head(marks).setOnes();
  weights.tail(rest).setConstant(CounterpartTuning::kHold * static_cast<double>(marks) /
                                 static_cast<double>(rest));
  motion = FitSimilarity(a, b, weights, false);
  return true;
}

/// Fits a part that is already near its counterpart to it by similarity ICP. The identity if that
/// brings it no closer, or changes its scale too much.
Similarity3 OntoCounterpart(const LoosePart& part, const PointsX3& points, const FacesX3& faces,
                            const LoosePart& other, const Mesh& target) {
  const std::vector<int> some = SomeOf(part.vertices, kCounterpartFeet);
  const PointsX3 start = RowsOf(points, some), theirs = RowsOf(target.points, other.vertices);
  const PointsX3 normals = RowsOf(VertexNormals(points, faces), some);
  const PointsX3 their_normals = RowsOf(VertexNormals(target.points, target.faces), other.vertices);
  const KdTree tree(theirs);
  Similarity3 motion;
  double first = 0, last = 0;
  for (int round = 0; round <= CounterpartTuning::kCounterpartRounds; ++round) {
    PointsX3 goals = Transformed(motion, start);
    const PointsX3 at = goals;
    for (Eigen::Index i = 0; i < at.rows(); ++i)
      for (const KdTree::Neighbor& near : tree.Nearest(at.row(i).transpose(), 8)) {
        const Vector3d normal = their_normals.row(near.index);
        if (normal.dot(motion.rotation * normals.row(i).transpose()) < CounterpartTuning::kFacing)
          continue;
        // Goes to the plane, and partly to the point, so that flat parts do not slide.
        const Vector3d way = theirs.row(near.index) - at.row(i);
        goals.row(i) += (normal * normal.dot(way) +
                         CounterpartTuning::kToPoint * (way - normal * normal.dot(way)))
                            .transpose();
        break;
      }
    last = (goals - at).squaredNorm();
    if (round == 0) first = last;
    if (round < CounterpartTuning::kCounterpartRounds)
      motion = FitSimilarity(start, goals, Eigen::VectorXd::Ones(start.rows()));
  }
  const bool sized = motion.scale < CounterpartTuning::kCounterpartGrowth &&
                     motion.scale > 1 / CounterpartTuning::kCounterpartGrowth;
  return last < first && sized ? motion : Similarity3{};
}

}  // namespace

RefinedParts RefineLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved,
                              const Mesh& target, const LooseParts& target_parts,
                              const std::vector<LandmarkGoal>& landmarks) {
  RefinedParts refined{moved};
  std::vector<Similarity3> motions(parts.parts.size());
  const std::vector<Vector3d> theirs = Centres(target_parts, target.points, target.faces);
  const std::vector<Vector3d> ours = Centres(parts, moved, source.faces);
  for (std::size_t i = 0; i < parts.parts.size(); ++i) {
    const LoosePart& part = parts.parts[i];
    Similarity3 own;
    if (part.parent >= 0) {
      motions[i] = motions[part.parent];
      Apply(motions[i], part.vertices, refined.points);
    }
    if (OntoLandmarks(part, refined.points, landmarks, own)) {
      ++refined.by_landmarks;
    } else {
      const int other = NearestCentre(ours[i], theirs);
      if (other < 0 || NearestCentre(theirs[other], ours) != static_cast<int>(i)) continue;
      const double size = BoundingDiagonal(RowsOf(refined.points, part.vertices)),
                   ratio = target_parts.parts[other].diagonal / size;
      if (!(ratio < CounterpartTuning::kSizeAlike) ||
          !(ratio > 1 / CounterpartTuning::kSizeAlike) ||
          (theirs[other] - ours[i]).norm() > CounterpartTuning::kCentreReach * size)
        continue;
      own.translation = theirs[other] - (motions[i] * ours[i]);
      PointsX3 shifted = refined.points;
      Apply(own, part.vertices, shifted);
      const Similarity3 onto =
          OntoCounterpart(part, shifted, source.faces, target_parts.parts[other], target);
      own = {onto.scale, onto.rotation, onto * own.translation};
      ++refined.by_counterpart;
    }
    Apply(own, part.vertices, refined.points);
    motions[i] = {own.scale * motions[i].scale, own.rotation * motions[i].rotation,
                  own * motions[i].translation};
  }
  return refined;
}

}  // namespace keypose::registration
