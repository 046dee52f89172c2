#include "register/auto/flipped_face_repair.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/geometry.h"
#include "deform/arap/arap_fit.h"
#include "deform/solvers/sparse_pattern.h"
#include "register/quality/flipped_faces.h"

namespace keypose::registration {

namespace {

constexpr int kPasses = 2, kRounds = 5;  // patches that were mended drop out, and the others fall
                                         // apart into smaller ones, once
constexpr int kRings = 3, kFreeRings = 1;
constexpr int kChoices = 64, kBendingSteps = 10;
// way across the plane between two walls: more is no slip but another error
constexpr double kFarthest = 0.004;
constexpr double kSameSide = 0.2;   // cosine from which on a target face is of the face's own wall
constexpr double kBeyond = 0.0004;  // by how much, and
// how many times the way, a face is asked to go: its neighbours hold it
constexpr double kFurther = 1.1;
constexpr double kPush = 30;      // weight, in units of the shape term, at each corner
constexpr double kRimHold = 1e4;  // weight
// share of the surface's pull that a face on the wrong wall still feels
constexpr double kFreeSurface = 0.02;
// of the pull onto its plane that pulls a vertex back to its place
constexpr double kPointShare = 0.03;

/// Marked vertices and those of `rings` rings of faces around them.
std::vector<char> Grown(std::vector<char> marked, const FacesX3& faces, int rings) {
  for (int r = 0; r < rings; ++r) {
    std::vector<char> next = marked;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      if (marked[faces(f, 0)] || marked[faces(f, 1)] || marked[faces(f, 2)])
        for (int k = 0; k < 3; ++k) next[faces(f, k)] = 1;
    marked = std::move(next);
  }
  return marked;
}

/// Patches around opposed faces, bent together: their rims keep them apart.
class Patches {
 public:
  Patches(const BentMesh& bent, const std::vector<char>& opposed, const TargetFaces& target_sides);
  void Run();
  void WriteTo(PointsX3& points) const;

 private:
  /// What a face was asked for: its centre is to go as far as `goal` along `direction`.
  struct Push {
    Eigen::RowVector3d direction;
    double goal;
    Eigen::Index face;
  };

  void Cut(const std::vector<char>& opposed);
  void HoldPlaces();
  std::vector<char> Judge();
  void PushAcross(const std::vector<char>& opposed);
  void Bend();

  const BentMesh& bent_;
  const TargetFaces& target_;
  std::vector<int> vertices_;           // of the whole mesh
  FacesX3 faces_;                       // of the patches' own numbers
  PointsX3 start_, now_, best_;         // positions
  PointsX3 start_normals_;              // of vertices
  PointsX3 start_face_normals_;         // of faces
  std::vector<char> start_opposed_;     // of faces
  std::vector<char> free_, rim_;        // of vertices
  std::vector<int> component_, least_;  // of vertices; of components, the fewest bad faces
  std::optional<ArapFit> fit_;
  Pulls places_{0};
  std::vector<Push> pushes_;
};

Patches::Patches(const BentMesh& bent, const std::vector<char>& opposed,
                 const TargetFaces& target_sides)
    : bent_(bent), target_(target_sides) {
  Cut(opposed);
  const auto n = static_cast<Eigen::Index>(vertices_.size());
  const PointsX3 rest = bent.rest(vertices_, Eigen::all);
  start_ = bent.moved(vertices_, Eigen::all);
  start_normals_ = PointsX3(VertexNormals(bent.moved, bent.faces)(vertices_, Eigen::all));
  start_face_normals_ = FaceNormals(start_, faces_);
  now_ = best_ = start_;
  std::vector<Eigen::Matrix3d> maps;
  for (int v : vertices_) maps.push_back(bent.maps[v]);
  fit_.emplace(rest, faces_, Eigen::VectorXd(), bent.smoothing);
  fit_->SetRigidity(bent.rigidity);
  fit_->SetMaps(std::move(maps));
  std::vector<std::pair<int, int>> edges;
  for (Eigen::Index f = 0; f < faces_.rows(); ++f)
    for (int k = 0; k < 3; ++k) edges.emplace_back(faces_(f, k), faces_(f, (k + 1) % 3));
  int components = 0;
  component_ = Components(static_cast<int>(n), edges, components);
  least_.assign(components, std::numeric_limits<int>::max());
  HoldPlaces();
}

void Patches::Cut(const std::vector<char>& opposed) {
  const FacesX3& faces = bent_.faces;
  std::vector<char> seed(bent_.moved.rows(), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) seed[faces(f, k)] |= opposed[f];
  const std::vector<char> free = Grown(seed, faces, kFreeRings),
                          inside = Grown(free, faces, kRings - kFreeRings);
  std::vector<int> own(inside.size(), -1);
  for (std::size_t v = 0; v < inside.size(); ++v) {
    if (!inside[v]) continue;
    own[v] = static_cast<int>(vertices_.size());
    vertices_.push_back(static_cast<int>(v));
    free_.push_back(free[v]);
  }
  rim_.assign(vertices_.size(), 0);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    if (inside[faces(f, 0)] && inside[faces(f, 1)] && inside[faces(f, 2)]) {
      kept.push_back(f);
      start_opposed_.push_back(opposed[f]);
      continue;
    }
    for (int k = 0; k < 3; ++k)
      if (own[faces(f, k)] >= 0) rim_[own[faces(f, k)]] = 1;
  }
  faces_.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t f = 0; f < kept.size(); ++f)
    for (int k = 0; k < 3; ++k) faces_(static_cast<Eigen::Index>(f), k) = own[faces(kept[f], k)];
}

/// The surface pulls as it did in the fit, which had come to rest: each vertex to its own tangent
/// plane.
void Patches::HoldPlaces() {
  places_ = Pulls(start_.rows());
  const double per_area = bent_.surface_weight / SurfaceArea(bent_.rest, bent_.faces);
  for (Eigen::Index v = 0; v < start_.rows(); ++v) {
    if (rim_[v]) {
      places_.AddPoint(v, kRimHold, start_.row(v).transpose());
      continue;
    }
    const double weight = per_area * fit_->vertex_areas()[v] * (free_[v] ? kFreeSurface : 1);
    places_.AddPlane(v, weight, start_normals_.row(v).transpose(), start_.row(v).transpose());
    places_.AddPoint(v, kPointShare * weight, start_.row(v).transpose());
  }
}

/// Which faces oppose the target now; components that are better than ever are kept.
std::vector<char> Patches::Judge() {
  const std::vector<char> opposed = target_.Opposed(now_, faces_);
  const PointsX3 normals = FaceNormals(now_, faces_);
  std::vector<int> bad(least_.size(), 0);
  for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
    const bool turned = !start_opposed_[f] && normals.row(f).dot(start_face_normals_.row(f)) < 0;
    if (opposed[f] || turned) ++bad[component_[faces_(f, 0)]];
  }
  for (Eigen::Index v = 0; v < now_.rows(); ++v)
    if (bad[component_[v]] < least_[component_[v]]) best_.row(v) = now_.row(v);
  for (std::size_t c = 0; c < bad.size(); ++c) least_[c] = std::min(least_[c], bad[c]);
  return opposed;
}

void Patches::PushAcross(const std::vector<char>& opposed) {
  const PointsX3 centres = FaceCentres(now_, faces_), normals = FaceNormals(now_, faces_);
  for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
    if (!opposed[f]) continue;
    const std::vector<KdTree::Neighbor> near =
        target_.tree.Nearest(centres.row(f).transpose(), kChoices);
    double way = kFarthest;
    Eigen::RowVector3d direction = Eigen::RowVector3d::Zero();
    for (const KdTree::Neighbor& own : near) {
      if (normals.row(f).dot(target_.normals.row(own.index)) < kSameSide) continue;
      const Eigen::RowVector3d across =
          target_.centres.row(own.index) - target_.centres.row(near[0].index);
      const double length = across.norm();
      const double needed = (own.squared_distance - near[0].squared_distance) / 2;
      if (!(needed < way * length)) continue;
      way = needed / length;
      direction = across / length;
    }
    if (way < kFarthest)
      pushes_.push_back({direction, direction.dot(centres.row(f)) + kFurther * way + kBeyond, f});
  }
}

void Patches::Bend() {
  Pulls pulls = places_;
  for (const Push& push : pushes_) {
    double at = 0;
    for (int k = 0; k < 3; ++k) at += push.direction.dot(now_.row(faces_(push.face, k))) / 3;
    if (at > push.goal + kBeyond) continue;
    for (int k = 0; k < 3; ++k) {
      const int v = faces_(push.face, k);
      if (!rim_[v])
        pulls.AddPlane(v, kPush, push.direction.transpose(),
                       (now_.row(v) + (push.goal - at) * push.direction).transpose());
    }
  }
  fit_->SetWeights(pulls.MeanWeights());
  now_ = fit_->FitPositions(pulls, now_, kBendingSteps);
  fit_->FitMaps(now_);
}

void Patches::Run() {
  for (int round = 0;; ++round) {
    const std::vector<char> opposed = Judge();
    if (round == kRounds) return;
    // The first round only lets go, so that folds open by themselves.
    if (round > 0) PushAcross(opposed);
    Bend();
  }
}

void Patches::WriteTo(PointsX3& points) const {
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    if (!rim_[v]) points.row(vertices_[v]) = best_.row(v);
}

int Count(const std::vector<char>& marks) {
  return static_cast<int>(std::count(marks.begin(), marks.end(), 1));
}

}  // namespace

FlippedFaceRepair RepairFlippedFaces(const BentMesh& bent, const PointsX3& target_points,
                                     const FacesX3& target_faces) {
  FlippedFaceRepair result{bent.moved};
  const TargetFaces target_sides(target_points, target_faces);
  std::vector<char> opposed = target_sides.Opposed(bent.moved, bent.faces);
  result.before = result.after = Count(opposed);
  for (int pass = 0; pass < kPasses && result.after > 0; ++pass) {
    PointsX3 points = result.points;
    Patches patches({bent.rest, bent.faces, result.points, bent.maps, bent.rigidity, bent.smoothing,
                     bent.surface_weight},
                    opposed, target_sides);
    patches.Run();
    patches.WriteTo(points);
    std::vector<char> now = target_sides.Opposed(points, bent.faces);
    if (Count(now) >= result.after) break;
    result.after = Count(now);
    result.points = std::move(points);
    opposed = std::move(now);
  }
  return result;
}

}  // namespace keypose::registration
