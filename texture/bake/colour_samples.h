// Colour samples: what the photographs show of a point of the surface, and how far they agree.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "texture/bake/bake_view.h"
#include "texture/bake/labels.h"
#include "texture/bake/view_alignment.h"

namespace keypose::texture {

/// What one view shows of one point.
struct ColorSample {
  int view = 0;
  Eigen::Vector3f fine;  ///< linear light, gain applied
  /// square roots, of fine and of the mean over 8 times as much: steps of about equal visibility. A
  /// highlight shows in the low band beyond its rim
  Eigen::Vector3f root, low_root;
  float weight = 0;   ///< pixels of the photograph, sharpness, trust: its part of the mean
  float quality = 0;  ///< weight x cosine^2: how good it is to be painted from alone
  /// Its part in what the views agree upon; flatter than `weight`, since the view from straight
  /// ahead may be the one that sees the lamp.
  float consensus_weight = 0;
  float trust = 0;      ///< that the view sees the point, (0, 1]; part of all of the above
  float agreement = 1;  ///< with the other views, (0, 1]
};

/// A point on a face.
struct SurfacePoint {
  int face = 0;
  Eigen::Vector3f weights;  ///< barycentric
};

/// What all views together show of a face.
struct FaceViews {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< linear light, by weight and agreement
  std::vector<LabelCandidate> candidates;          ///< ascending
};

/// One view of a face, prepared so that each texel of it is looked at quickly.
struct FaceSight {
  int view = 0;
  /// pixels and depths at the corners may be interpolated; else each texel is projected
  bool flat = true;
  Eigen::Matrix<float, 2, 3> pixels;  ///< of the photograph, at the corners
  Eigen::Vector3f depths;             ///< at the corners
  float level = 0;                    ///< of the photograph's pyramid
};

/// All views, their gains and warps, and the texels of one atlas.
class ColorSampler {
 public:
  /// @param used          one a view: 0 leaves it out
  /// @param warps         one a view, or none at all
  /// @param texture_size  of the atlas whose texels are painted
  ColorSampler(const Mesh& mesh, const std::vector<BakeView>& views,
               const std::vector<Eigen::Vector3f>& gains, const std::vector<Warp>& warps,
               const std::vector<char>& used, int texture_size, double max_angle_deg,
               double strictness);

  /// One sample for each used view that sees the point, ascending, with agreements. Colours are
  /// means over `texels` texels each way.
  void CollectColorSamples(const SurfacePoint& point, double texels,
                           std::vector<ColorSample>& samples) const;
  /// False when a corner of the face is behind the camera.
  bool Prepare(int view, int face, FaceSight& sight) const;
  /// One view's colour of a texel, gain applied;
  /// @return trust in it, 0 when the view does not see
  /// the point.
  float Look(const FaceSight& sight, const SurfacePoint& point, Eigen::Vector3f& color) const {
    const BakeView& from = views_[sight.view];
    Eigen::Vector2f pixel;
    float trust;
    if (sight.flat) {
      pixel = sight.pixels * point.weights;
      trust = from.TrustAt(pixel, sight.depths.dot(point.weights));
    } else {
      trust = SeeExactly(sight.view, point, pixel);
    }
    if (trust <= 0) return 0;
    const Sample sample = from.ColorAt(pixel, sight.level);
    if (sample.alpha <= 0) return 0;
    color = sample.color.cwiseProduct(gains_[sight.view]);
    return trust;
  }

  /// The views that see each face, judged at four points of it.
  std::vector<FaceViews> LookAtFaces() const;
  const Mesh& mesh() const { return mesh_; }
  int view_count() const { return static_cast<int>(views_.size()); }

 private:
  void FindViews(const std::vector<char>& used);
  void WeighSharpness();
  void MeasureTexels(int texture_size);
  Sighting See(int view, const Eigen::Vector3d& x) const;
  float SeeExactly(int view, const SurfacePoint& point, Eigen::Vector2f& pixel) const;
  void AddColorSample(int view, const Sighting& sighting, double pixels, double cosine,
                      std::vector<ColorSample>& samples) const;
  FaceViews LookAtFace(int face) const;

  const Mesh& mesh_;
  const std::vector<BakeView>& views_;
  const std::vector<Eigen::Vector3f>& gains_;
  const std::vector<Warp>& warps_;
  double least_cosine_, strictness_;
  PointsX3 face_normals_, vertex_normals_;
  std::vector<std::vector<int>> facing_;  ///< views that may see a face, ascending
  std::vector<double> sharpness_;         ///< of the views, relative to the median
  Eigen::VectorXd areas_;                 ///< of the faces, in world units squared
  std::vector<double> area_per_texel_;    ///< the same divided by the face's texels
};

}  // namespace keypose::texture
