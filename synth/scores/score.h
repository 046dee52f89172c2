// Errors of a reconstruction: cameras, surface, correspondence.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::synth {

struct CameraScore {
  Similarity3 truth_from_model;  ///< fitted to the centres of the cameras that both scenes have
  int placed = 0, total = 0;     ///< number of true cameras in the model, and in total
  double mean_m = 0, max_m = 0;  ///< distance of the centres after the fit
  double mean_over_distance = 0,
         max_over_distance = 0;  ///< divided by the mean distance of the true cameras from `center`
};

/// Cameras are matched by name.
/// @param center  of the true surface
/// @throws InputError  fewer than 3 shared names
CameraScore ScoreCameras(const Scene& truth, const Scene& model, const Eigen::Vector3d& center);

/// Distances between surfaces as fractions of the true bounding diagonal.
struct SurfaceScore {
  double mean_to_truth = 0, p95_to_truth = 0,
         max_to_truth = 0;  ///< from points of the mesh to the true surface
  double mean_from_truth = 0, p95_from_truth = 0,
         max_from_truth = 0;  ///< from points of the true surface to the mesh
  double mean() const { return (mean_to_truth + mean_from_truth) / 2; }
};

/// @param mesh  in the truth's frame. Distances are taken at 40,000 points, uniform by area, of
/// each.
/// Same bits for any thread count.
SurfaceScore ScoreSurface(const Mesh& truth, const Mesh& mesh);

/// Refines a similarity so that the mesh lies closer to the true surface (iterative closest points,
/// without the farthest tenth).
Similarity3 RefineAlignment(const Mesh& truth, const Mesh& mesh, const Similarity3& truth_from_mesh,
                            int rounds = 40);

/// Errors of a registered template against exact correspondence.
struct CorrespondenceScore {
  /// distance of a vertex from the true position of its material point / diagonal of truth_b
  double mean = 0, p95 = 0, max = 0;
  int flipped = 0;  ///< faces that oppose the true normal of their material points
};

/// @param template_a    template mesh in the frame of truth_a; the material point of a vertex is
/// its closest point on truth_a
/// @param registered_b  the template registered onto pose B, in the frame of truth_b
/// @throws InputError  the vertex counts of registered mesh and template differ, or those of the
/// truths
CorrespondenceScore ScoreCorrespondence(const Mesh& truth_a, const Mesh& truth_b,
                                        const Mesh& template_a, const PointsX3& registered_b);

}  // namespace keypose::synth
