// Projective texturing: what several cameras show of a moving surface, blended texel by texel.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "motion/video3d/camera_exposure.h"
#include "motion/video3d/filmed_view.h"
#include "motion/video3d/surface_texels.h"

namespace keypose::motion {

struct BlendOptions {
  double smoothing = 0.2;  ///< share of the frame before in the weights of a frame, in [0, 1)
  bool agreement = true;   ///< views that contradict the others get less weight
};

/// Blends frame after frame.
///
/// The weight of a view at a texel is cos^4 of its angle, times how well it agrees with the median
/// of all views there; both are smoothed in time. Times its trust (FilmedView), which is not: a
/// view that is hidden in this frame has no weight in it. Source: Carranza, Theobalt, Magnor,
/// Seidel, Free-viewpoint video of human actors, SIGGRAPH 2003 (weights by angle, visibility); de
/// Aguiar et al. (the third paper), 5.2. Departs: textures in the mesh's layout, agreement,
/// smoothing.
class ViewBlender {
 public:
  /// Refers to `faces` and `texels`, which must outlive this.
  ViewBlender(const FacesX3& faces, const SurfaceTexels& texels, int cameras,
              const BlendOptions& options);

  /// The next frame.
  /// @param views  one per camera; those that see nothing are skipped
  /// @param gains  one per camera
  /// Same bits for any thread count.
  TexelColors Next(const PointsX3& points, const std::vector<FilmedView>& views,
                   const std::vector<Eigen::Vector3f>& gains);

 private:
  struct Blended {
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    float sure = 0;
  };
  Blended Blend(std::vector<Sighting>& seen, float* smoothed,
                const std::vector<Eigen::Vector3f>& gains) const;

  const FacesX3& faces_;
  const SurfaceTexels& texels_;
  int cameras_;
  BlendOptions options_;
  bool first_ = true;
  std::vector<float> smoothed_;  // texels x cameras: weight by angle and agreement
};

/// Pairs of views at vertices that both see well, for LevelExposures.
/// @param most  about how many vertices are looked at
std::vector<ColorPair> PairsOfViews(const PointsX3& points, const FacesX3& faces,
                                    const std::vector<FilmedView>& views, int most);

}  // namespace keypose::motion
