// Image features at points of a textured surface, and their matches in photographs of it, whatever
// the pose of the surface and the camera.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/image.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

using Descriptors = Eigen::Matrix<float, Eigen::Dynamic, 128, Eigen::RowMajor>;

/// Features of one picture.
struct PictureFeatures {
  std::vector<Eigen::Vector2d> pixels;  ///< pixel centres at whole numbers
  std::vector<double> sizes;            ///< diameters [px]
  Descriptors descriptors;              ///< unit length
};

/// SIFT features whose centres are inside the mask, strongest first.
///
/// @param picture  RGB or grey
/// @param mask     same size, 1 channel, > 127 is object; empty: all
/// Descriptors are those of RootSIFT. Deterministic.
/// Sources: Lowe, IJCV 2004; Arandjelovic, Zisserman, CVPR 2012.
PictureFeatures FindFeatures(const Image8& picture, const Image8& mask, int most);

/// The mask of a prepared view, 255 inside.
Image8 MaskOf(const PreparedView& view);

/// A place of the surface that a photograph shows.
struct FeatureMatch {
  SurfacePoint point;  ///< on the textured mesh
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double similarity = 0;  ///< cosine of the two descriptors
  double ratio = 1;       ///< distance of the descriptors over that to the best at another place
};

struct SurfaceFeatureOptions {
  int directions = 48;       ///< renders from directions all round
  int size = 600;            ///< of a render, longer side [px]
  int most = 1200;           ///< features of a render
  double best_ratio = 0.88;  ///< a match must beat other places of the surface by this
};

/// Features of a textured mesh, seen from all sides.
class SurfaceFeatures {
 public:
  /// @param mesh     with UVs in [0,1]
  /// @param texture  RGB
  /// @throws InputError  no UVs
  /// Cost: options.directions renders and feature searches.
  /// Same bits for any thread count.
  SurfaceFeatures(const Mesh& mesh, const Image8& texture,
                  const SurfaceFeatureOptions& options = {}, Progress* progress = nullptr);

  int size() const { return static_cast<int>(points_.size()); }
  const SurfacePoint& point(int i) const { return points_[i]; }
  /// The places that a picture's features show. Each feature has one match at most, and each
  /// place of the surface one feature.
  std::vector<FeatureMatch> Match(const PictureFeatures& picture) const;

 private:
  SurfaceFeatureOptions options_;
  std::vector<SurfacePoint> points_;
  PointsX3 positions_;  // at rest
  double diagonal_ = 0;
  Descriptors descriptors_;
};

}  // namespace keypose
