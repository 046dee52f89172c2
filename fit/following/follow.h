// A whole moving mesh bent into films: two passes over the frames, calm in time, volume kept.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/values/progress.h"
#include "deform/volume/volume_correction.h"
#include "fit/following/frame_fit.h"

namespace keypose::fit {

/// Where frames and films come from. A frame's views are those with a mask that is not empty.
struct FollowSource {
  int frames = 0;
  /// V x 3 of a frame before bending; called from several threads
  std::function<PointsX3(int frame)> base;
  /// prepared views of `count` frames from `first` on; called in order, once in each pass
  std::function<std::vector<std::vector<PreparedView>>(int first, int count)> views;
};

struct FollowOptions {
  FrameFitOptions fit;
  double calm_frames = 1.5;  ///< standard deviation of the means in time
};

/// Displacements of the mesh's coarse vertices in each frame.
/// @throws SolverError  @throws Cancelled
/// Same bits for any thread count.
/// See docs/algorithms/follow.md.
std::vector<Offsets> FollowFilms(const FollowedMesh& mesh, const FollowSource& source,
                                 const SurfaceTexture* texture, const FollowOptions& options,
                                 Progress* progress = nullptr);

/// The bent frames.
class FollowedFrames {
 public:
  /// Refers to all of these, which must outlive it.
  /// @param keep_volume  each closed part's volume changes from frame to frame as it does before
  /// bending; in the mean it is what the films ask for
  FollowedFrames(const FollowedMesh& mesh, const FollowSource& source,
                 const std::vector<Offsets>& offsets, bool keep_volume);
  /// May be called from several threads.
  BentFrame At(int frame) const;
  /// Mean over the frames, of all parts together, over that before bending.
  double volume_ratio() const { return ratio_; }

 private:
  std::vector<double> Targets(const PointsX3& base) const;

  const FollowedMesh& mesh_;
  const FollowSource& source_;
  const std::vector<Offsets>& offsets_;
  std::optional<PoissonSystem> system_;
  std::optional<VolumeCorrection> correction_;
  std::vector<double> growth_;  // of each part: mean factor on its volume
  double ratio_ = 1;
};

/// Mean length of the vertices' second difference over three frames: how much a surface flickers,
/// beside what its motion accelerates.
double Flicker(const PointsX3& before, const PointsX3& now, const PointsX3& after);

}  // namespace keypose::fit
