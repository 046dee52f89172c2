// One frame of a moving mesh, bent until it agrees with what several cameras filmed then.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "fit/appearance/textured_render.h"
#include "fit/following/calm.h"
#include "fit/following/followed_mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

struct FrameFitOptions {
  double stiffness = 1;  ///< factor on that of the rounds
  bool grey = true;      ///< where two films show the surface alike; false: outlines alone
};

/// What is known before a frame is bent; nothing in the first pass, which may be centimetres off.
struct FollowStart {
  /// C x 3 of the coarse vertices: the mean of all frames, by which the mesh at rest is bent. Else
  /// it would be pulled back to a shape that is not the actor's.
  const PointsX3* shape = nullptr;
  /// C x 3: what the frames around say; where bending begins, and where what no view holds stays
  const PointsX3* offsets = nullptr;
};

/// @param base     V x 3 of the frame before bending, in the views' world
/// @param views    prepared with two levels or more; those with an empty mask left out
/// @param texture  of the mesh, or null: then only films are compared with films
/// @param start    both of its parts, or none
/// @return of the coarse vertices; `sure` grows with what views say about the vertex along its
/// normal, as 1 - 1 / (1 + their number) does when each shows it well
/// @throws SolverError
/// Same bits for any thread count; may be called from several threads.
/// See docs/algorithms/follow.md.
Offsets FitFrame(const FollowedMesh& mesh, const PointsX3& base,
                 const std::vector<PreparedView>& views, const SurfaceTexture* texture,
                 const FollowStart& start, const FrameFitOptions& options);

/// The frame with its coarse vertices displaced.
struct BentFrame {
  PointsX3 points;  ///< V x 3
  int flipped = 0;  ///< faces that bending turned over, and that could not be turned back
};
BentFrame Bent(const FollowedMesh& mesh, const PointsX3& base, const PointsX3& offsets);

/// Intersection over union of the mesh and the masks, mean of the views; 1 without views.
double MeanOverlap(const PointsX3& points, const FacesX3& faces,
                   const std::vector<PreparedView>& views);

}  // namespace keypose::fit
