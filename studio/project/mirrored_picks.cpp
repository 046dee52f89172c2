#include "studio/project/mirrored_picks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mirror_plane.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "studio/project/picks.h"

namespace keypose::studio {

using Eigen::Vector3d;
using nlohmann::json;

namespace {

// Of the diagonal: nearer to the plane than this a pick is its own partner; nearer to another pick,
// the partner is there; farther from the surface, the other half has no such place.
constexpr double kInPlane = 0.02, kSamePlace = 0.03, kMostOff = 0.04;

json PlaceJson(int face, const Vector3d& barycentric) {
  return {{"face", face}, {"barycentric", {barycentric[0], barycentric[1], barycentric[2]}}};
}

/// The pose's net and scan, as far as there are any.
struct PoseSurfaces {
  std::optional<Mesh> net;
  std::optional<RayScene> scan;
};

PoseSurfaces SurfacesOf(Snapshot& snapshot, const std::string& pose, const Mesh& whole) {
  PoseSurfaces surfaces;
  const auto net = snapshot.MeshPath(pose, MeshKind::kMesh);
  const auto scan = snapshot.MeshPath(pose, MeshKind::kClean);
  if (!net || !scan) return surfaces;
  Mesh mesh = ReadMesh(*net);
  // Of an older template.
  if (!SameFaces(mesh.faces, whole.faces)) return surfaces;
  const Mesh target = ReadMesh(*scan);
  surfaces.scan.emplace(target.points, target.faces);
  surfaces.net = std::move(mesh);
  return surfaces;
}

/// Where the other half of the figure has the place of a pick.
class OtherHalf {
 public:
  explicit OtherHalf(const Mesh& mesh)
      : mesh_(mesh),
        plane_(FindMirrorPlane(mesh.points, mesh.faces)),
        scene_(mesh.points, mesh.faces),
        normals_(FaceNormals(mesh.points, mesh.faces)),
        diagonal_(BoundingDiagonal(mesh.points)) {}

  const MirrorPlane& plane() const { return plane_; }
  double diagonal() const { return diagonal_; }
  std::optional<RayScene::Foot> PlaceOf(const Landmark& pick) const {
    const Vector3d here = PositionOf(pick, mesh_);
    if (std::abs(plane_.Distance(here)) < kInPlane * diagonal_) return std::nullopt;
    const RayScene::Foot foot = scene_.ClosestPoint(plane_.Mirrored(here));
    const bool near = std::sqrt(foot.squared_distance) < kMostOff * diagonal_;
    const Vector3d normal = plane_.Turned(normals_.row(pick.face));
    if (!near || normal.dot(normals_.row(foot.face)) <= 0) return std::nullopt;
    return foot;
  }

 private:
  const Mesh& mesh_;
  MirrorPlane plane_;
  RayScene scene_;
  PointsX3 normals_;
  double diagonal_;
};

json TargetJson(const PoseSurfaces& surfaces, const RayScene::Foot& source, double* off) {
  if (!surfaces.net) return nullptr;
  Vector3d there = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    there += source.barycentric[k] *
             surfaces.net->points.row(surfaces.net->faces(source.face, k)).transpose();
  const RayScene::Foot foot = surfaces.scan->ClosestPoint(there);
  *off = std::sqrt(foot.squared_distance);
  return PlaceJson(foot.face, foot.barycentric);
}

}  // namespace

json MirroredPicksJson(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  const std::string whole = snapshot.graph().template_pose;
  Mesh mesh;
  const std::vector<Landmark> picks = TemplatePicks(snapshot, &mesh);
  if (picks.empty())
    throw UsageError(fmt::format("pick places of one half of {} first; they are mirrored", whole));
  const OtherHalf other(mesh);
  if (!other.plane().found())
    throw UsageError(
        fmt::format("the two halves of {} differ by {:.1f} % of its size, so its landmarks cannot "
                    "be mirrored; pick them on both sides",
                    whole, 100 * other.plane().misfit));
  const PoseSurfaces surfaces = SurfacesOf(snapshot, pose, mesh);
  json mirrored = json::array();
  for (const Landmark& pick : picks) {
    const auto place = other.PlaceOf(pick);
    if (!place) continue;
    const bool has_partner = std::any_of(picks.begin(), picks.end(), [&](const Landmark& one) {
      return (PositionOf(one, mesh) - place->point).norm() < kSamePlace * other.diagonal();
    });
    if (has_partner) continue;
    double off = 0;
    const json target = TargetJson(surfaces, *place, &off);
    mirrored.push_back({{"of", pick.name},
                        {"source", PlaceJson(place->face, place->barycentric)},
                        {"target", target},
                        {"off", off / other.diagonal()}});
  }
  return {{"misfit", other.plane().misfit}, {"mirrored", mirrored}};
}

}  // namespace keypose::studio
