#include "armature/skinning/bone_heat.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/numbers/cholesky.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::armature {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kLeastCotangent = 1e-3;  // of a negative one: a slow way, but no source of heat
constexpr double kMostCotangent = 1e3;    // of slivers
constexpr double kInside = 1e-4;          // of the diagonal: where a ray begins below its vertex
constexpr int kMostBones = 65535;

/// A vertex's nearest bone.
struct Source {
  int bone = 0;
  double distance = 0;
  bool sees = false;
};

Vector3d NearestOn(const SkinBone& bone, const Vector3d& x) {
  const Vector3d along = bone.tail - bone.head;
  const double squared = along.squaredNorm();
  const double at = squared > 0 ? std::clamp((x - bone.head).dot(along) / squared, 0.0, 1.0) : 0;
  return bone.head + at * along;
}

Source NearestBone(const std::vector<SkinBone>& bones, const Vector3d& x) {
  Source nearest{0, std::numeric_limits<double>::infinity(), false};
  for (int b = 0; b < SizeOf(bones); ++b) {
    const double distance = (x - NearestOn(bones[b], x)).norm();
    if (distance < nearest.distance) nearest = {b, distance, false};
  }
  return nearest;
}

/// Whether the straight way from below a vertex to its bone stays inside the surface.
bool Sees(const RayScene& scene, const Vector3d& x, const Vector3d& normal, const Vector3d& goal,
          double diagonal) {
  const Vector3d from = x - kInside * diagonal * normal, way = goal - from;
  if (way.dot(normal) > 0) return false;  // the bone lies outside, above the vertex
  return !scene.Occluded(from, way, 0, 1);
}

std::vector<Source> SourcesOf(const Mesh& mesh, const std::vector<SkinBone>& bones) {
  const RayScene scene(mesh.points, mesh.faces);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const double diagonal = BoundingDiagonal(mesh.points);
  std::vector<Source> sources(mesh.vertex_count());
  ParallelFor(
      mesh.vertex_count(),
      [&](std::int64_t v) {
        const Vector3d x = mesh.points.row(v);
        Source source = NearestBone(bones, x);
        source.sees = Sees(scene, x, normals.row(v), NearestOn(bones[source.bone], x), diagonal);
        source.distance = std::max(source.distance, 1e-6 * diagonal);
        sources[v] = source;
      },
      256);
  return sources;
}

/// Parts of which no vertex sees its bone: all of theirs count as seeing.
int WarmBlindParts(const Mesh& mesh, std::vector<Source>& sources) {
  UnionFind parts(mesh.vertex_count());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) parts.Join(mesh.faces(f, 0), mesh.faces(f, k));
  std::map<int, bool> sees;
  for (int v = 0; v < SizeOf(sources); ++v) sees[parts.Find(v)] |= sources[v].sees;
  int blind = 0;
  for (const auto& [part, seeing] : sees) blind += !seeing;
  for (int v = 0; v < SizeOf(sources); ++v)
    if (!sees[parts.Find(v)]) sources[v].sees = true;
  return blind;
}

double HalfCotangent(const Vector3d& a, const Vector3d& b) {
  const double area = a.cross(b).norm(), dot = a.dot(b);
  if (!(area > 0)) return kLeastCotangent;
  return std::clamp(0.5 * dot / area, kLeastCotangent, kMostCotangent);
}

/// The lower triangle of L + diag(heat).
Eigen::SparseMatrix<double> SystemOf(const Mesh& mesh, const VectorXd& heat) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3),
                c = mesh.faces(f, (k + 2) % 3);
      if (a == b) continue;
      const Vector3d tip = mesh.points.row(c);
      const double weight =
          HalfCotangent(mesh.points.row(a).transpose() - tip, mesh.points.row(b).transpose() - tip);
      entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
      entries.emplace_back(a, a, weight);
      entries.emplace_back(b, b, weight);
    }
  for (int v = 0; v < mesh.vertex_count(); ++v) entries.emplace_back(v, v, heat[v]);
  Eigen::SparseMatrix<double> system(mesh.vertex_count(), mesh.vertex_count());
  system.setFromTriplets(entries.begin(), entries.end());
  return system;
}

void RequireBones(const std::vector<SkinBone>& bones) {
  if (bones.empty()) throw InputError("armature: the skeleton has no bones for the mesh");
  if (SizeOf(bones) > kMostBones)
    throw InputError("armature: a skeleton of " + std::to_string(bones.size()) +
                     " bones; at most " + std::to_string(kMostBones) + " are possible");
}

}  // namespace

BoneHeat HeatWeights(const Mesh& mesh, const std::vector<SkinBone>& bones, Progress* progress) {
  RequireUsable(mesh, "armature: the character's mesh");
  RequireArea(mesh, "armature: the character's mesh");
  RequireBones(bones);
  ReportProgress(progress, 0, "finding the nearest bones");
  std::vector<Source> sources = SourcesOf(mesh, bones);
  BoneHeat result;
  for (const Source& source : sources) result.seeing += source.sees;
  result.blind_parts = WarmBlindParts(mesh, sources);
  VectorXd areas = VertexAreas(mesh.points, mesh.faces);
  // A vertex without a face has only its own bone.
  areas = areas.cwiseMax(1e-9 * areas.mean());
  VectorXd heat(mesh.vertex_count());
  MatrixXd weights = MatrixXd::Zero(mesh.vertex_count(), SizeOf(bones));
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Source& source = sources[v];
    heat[v] = source.sees ? areas[v] / (source.distance * source.distance) : 0;
    weights(v, source.bone) = heat[v];
  }
  ReportProgress(progress, 0.3, "solving for the weights");
  const Eigen::SparseMatrix<double> system = SystemOf(mesh, heat);
  SparseCholesky solver;
  solver.Analyze(system);
  solver.Factor(system);
  solver.SolveInPlace(weights);
  result.weights = Pruned(weights);
  ReportProgress(progress, 1, "weights found");
  return result;
}

SkinWeights NearestBoneWeights(const PointsX3& points, const std::vector<SkinBone>& bones) {
  RequireBones(bones);
  SkinWeights skin;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const int bone = NearestBone(bones, points.row(v)).bone;
    skin.bones.push_back({static_cast<std::uint16_t>(bone), 0, 0, 0});
    skin.weights.push_back({1, 0, 0, 0});
  }
  return skin;
}

}  // namespace keypose::armature
