#include "synth/scores/pick.h"

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::synth {

Picks PickLandmarks(const Mesh& truth, const std::vector<TruthLandmark>& landmarks,
                    const Mesh& mesh, const Similarity3& truth_from_mesh, double reach) {
  const RayScene scene(mesh.points, mesh.faces);
  const Similarity3 mesh_from_truth = truth_from_mesh.Inverse();
  const double limit = reach * BoundingDiagonal(mesh.points);
  Picks picks;
  for (const TruthLandmark& landmark : landmarks) {
    const RayScene::Foot foot =
        scene.ClosestPoint(mesh_from_truth * Eigen::Vector3d(truth.points.row(landmark.vertex)));
    if (foot.face < 0 || std::sqrt(foot.squared_distance) > limit) {
      picks.out_of_reach.push_back(landmark.name);
      continue;
    }
    Landmark pick;
    pick.name = landmark.name;
    pick.face = foot.face;
    pick.barycentric = foot.barycentric;
    picks.landmarks.push_back(pick);
  }
  return picks;
}

}  // namespace keypose::synth
