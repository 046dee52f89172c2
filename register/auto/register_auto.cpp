#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/seams.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "register/auto/auto_registration.h"
#include "register/parts/parts.h"

namespace keypose::registration {

namespace {

/// The similarity transform that best explains a part's motion; the identity for fewer than three
/// vertices or a part without extent.
Similarity3 PartMotion(const PointsX3& before, const PointsX3& after,
                       const std::vector<int>& vertices) {
  PointsX3 a(std::ssize(vertices), 3), b = a;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    a.row(k) = before.row(vertices[k]);
    b.row(k) = after.row(vertices[k]);
  }
  return a.rows() < 3 || BoundingDiagonal(a) == 0 ? Similarity3{} : FitSimilarity(a, b);
}

/// The landmarks on the host, renumbered to the host's vertices.
std::vector<LandmarkGoal> OnHost(const std::vector<LandmarkGoal>& landmarks,
                                 const std::vector<int>& host_index) {
  std::vector<LandmarkGoal> kept;
  for (LandmarkGoal landmark : landmarks) {
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
      if (landmark.source.weights[k] > 0)
        inside = inside && host_index[landmark.source.vertices[k]] >= 0;
      landmark.source.vertices[k] = std::max(0, host_index[landmark.source.vertices[k]]);
    }
    if (inside) kept.push_back(landmark);
  }
  return kept;
}

void CheckInput(const Mesh& source, const Mesh& target, const std::vector<LandmarkGoal>& landmarks,
                const Eigen::VectorXd& stiffness) {
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  if (source.vertex_count() < 4)
    throw InputError("register: the source has fewer than 4 vertices; pass a template with faces");
  RequireArea(source, "register: source");
  RequireArea(target, "register: target");
  RequireStiffness(stiffness, source.vertex_count(), "register");
  RequireUsable(landmarks, source.vertex_count(), "register");
}

/// Registers the host alone. Then loose parts follow the surface they sit on, and move onto their
/// own landmarks or counterparts.
AutoResult WithLooseParts(const Mesh& source, const LooseParts& parts, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks,
                          const Eigen::VectorXd& stiffness, const AutoOptions& options,
                          Progress* progress) {
  const LooseParts target_parts = FindLooseParts(target);
  std::vector<int> host_index(source.vertex_count(), -1);
  for (std::size_t k = 0; k < parts.host_vertices.size(); ++k)
    host_index[parts.host_vertices[k]] = static_cast<int>(k);
  const Mesh host = HostOf(source, parts),
             target_host = target_parts.empty() ? target : HostOf(target, target_parts);
  Eigen::VectorXd host_stiffness(stiffness.size() == 0 ? 0 : host.vertex_count());
  for (Eigen::Index k = 0; k < host_stiffness.size(); ++k)
    host_stiffness[k] = stiffness[parts.host_vertices[k]];
  AutoResult result = RegisterSurface(host, target_host, OnHost(landmarks, host_index),
                                      host_stiffness, options, progress);
  const std::vector<Eigen::Matrix3d> of_host = std::move(result.transforms);
  const PointsX3 moved = MoveLoosePartsWithHost(source, parts, result.points);
  result.points = RefineLooseParts(source, parts, moved, target, target_parts, landmarks).points;
  result.transforms.assign(source.vertex_count(), Eigen::Matrix3d::Identity());
  for (std::size_t k = 0; k < parts.host_vertices.size(); ++k)
    result.transforms[parts.host_vertices[k]] = of_host[k];
  for (const LoosePart& part : parts.parts) {
    const Similarity3 motion = PartMotion(source.points, result.points, part.vertices);
    for (int v : part.vertices) result.transforms[v] = motion.scale * motion.rotation;
  }
  result.loose_parts = SizeOf(parts.parts);
  return result;
}

AutoResult RegisterWelded(const Mesh& source, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks,
                          const Eigen::VectorXd& stiffness, const AutoOptions& options,
                          Progress* progress) {
  const LooseParts parts = FindLooseParts(source);
  AutoResult result =
      parts.empty()
          ? RegisterSurface(source, target, landmarks, stiffness, options, progress)
          : WithLooseParts(source, parts, target, landmarks, stiffness, options, progress);
  if (!result.points.allFinite())
    throw SolverError("register: the result is not finite; the meshes may be degenerate");
  return result;
}

std::vector<LandmarkGoal> OnWelded(std::vector<LandmarkGoal> landmarks, const WeldedMesh& welded) {
  for (LandmarkGoal& landmark : landmarks)
    for (int& v : landmark.source.vertices) v = welded.of_input[v];
  return landmarks;
}

/// Stiffness on the welded mesh: a welded vertex gets the largest value of its doubles.
Eigen::VectorXd OnWelded(const Eigen::VectorXd& stiffness, const WeldedMesh& welded) {
  if (stiffness.size() == 0) return {};
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(welded.mesh.vertex_count());
  for (Eigen::Index v = 0; v < stiffness.size(); ++v)
    largest[welded.of_input[v]] = std::max(largest[welded.of_input[v]], stiffness[v]);
  return largest;
}

/// Copies the result of each welded vertex to all its doubles at seams.
AutoResult AtSeams(AutoResult result, const WeldedMesh& welded) {
  result.points = PointsX3(result.points(welded.of_input, Eigen::all));
  std::vector<Eigen::Matrix3d> transforms;
  for (int v : welded.of_input) transforms.push_back(result.transforms[v]);
  result.transforms = std::move(transforms);
  return result;
}

}  // namespace

AutoResult RegisterAuto(const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkGoal>& landmarks,
                        const Eigen::VectorXd& stiffness, const AutoOptions& options,
                        Progress* progress) {
  CheckInput(source, target, landmarks, stiffness);
  const Seams of_source = FindSeams(source), of_target = FindSeams(target);
  if (of_target.empty() && of_source.empty())
    return RegisterWelded(source, target, landmarks, stiffness, options, progress);
  const WeldedMesh whole = Weld(source, of_source), pose = Weld(target, of_target);
  AutoResult result = AtSeams(RegisterWelded(whole.mesh, pose.mesh, OnWelded(landmarks, whole),
                                             OnWelded(stiffness, whole), options, progress),
                              whole);
  result.seam_vertices = of_source.joined;
  return result;
}

}  // namespace keypose::registration
