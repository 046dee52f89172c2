// Colour samples: the photographs' colours at a point of the surface, and their agreement.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "texture/bake/bake_view.h"
#include "texture/bake/labels.h"
#include "texture/bake/view_alignment.h"

namespace keypose::texture {

/// One view's colour at one point.
struct ColorSample {
  int view = 0;
  Eigen::Vector3f fine;  ///< linear light, gain applied
  /// square roots, of fine and of the mean over 8 times the width: steps of about equal visibility.
  /// A highlight appears in the low band beyond its own border
  Eigen::Vector3f root, low_root;
  float weight = 0;   ///< from the photograph's pixels, sharpness and trust: weight in the mean
  float quality = 0;  ///< weight x cosine^2: suitability for painting from this view alone
  /// Weight in the consensus. It varies less than `weight`, since the most frontal view may be the
  /// one with the highlight.
  float consensus_weight = 0;
  float trust = 0;      ///< visibility of the point, (0, 1]; a factor of all of the above
  float agreement = 1;  ///< with the other views, (0, 1]
};

/// A point on a face.
struct SurfacePoint {
  int face = 0;
  Eigen::Vector3f weights;  ///< barycentric
};

/// The colours of a face in all views.
struct FaceViews {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< linear light, weighted mean with agreement
  std::vector<LabelCandidate> candidates;          ///< ascending
};

/// One view of a face, prepared for fast evaluation of its texels.
struct FaceSight {
  int view = 0;
  /// pixels and depths are interpolated between the corners; else each texel is projected
  bool flat = true;
  Eigen::Matrix<float, 2, 3> pixels;  ///< of the photograph, at the corners
  Eigen::Vector3f depths;             ///< at the corners
  float level = 0;                    ///< of the photograph's pyramid
};

/// All views with their gains and warps, and the texels of one atlas.
class ColorSampler {
 public:
  /// @param used          one per view: 0 leaves it out
  /// @param warps         one per view, or empty
  /// @param texture_size  of the atlas whose texels are painted
  ColorSampler(const Mesh& mesh, const std::vector<BakeView>& views,
               const std::vector<Eigen::Vector3f>& gains, const std::vector<Warp>& warps,
               const std::vector<char>& used, int texture_size, double max_angle_deg,
               double strictness);

  /// One sample for each used view that sees the point, in ascending order, with agreements.
  /// Colours are means over `texels` texels in each direction.
  void CollectColorSamples(const SurfacePoint& point, double texels,
                           std::vector<ColorSample>& samples) const;
  /// @return false when a corner of the face is behind the camera
  bool Prepare(int view, int face, FaceSight& sight) const;
  /// One view's colour of a texel, with gain.
  /// @return trust; 0 if the view does not see the point
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

  /// The views that see each face, evaluated at four points of it.
  std::vector<FaceViews> LookAtFaces() const;
  const Mesh& mesh() const { return mesh_; }
  int view_count() const { return SizeOf(views_); }

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
