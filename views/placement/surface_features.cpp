#include "views/placement/surface_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/features2d.hpp>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth) and on photographs of the plush dog.
struct SurfaceFeatureTuning {
  KEYPOSE_TUNED(double, kContrast, 0.005);    // least contrast of a feature, of the grey range
  KEYPOSE_TUNED(double, kSamePlace, 0.03);    // distance between different places [diagonal]
  KEYPOSE_TUNED(double, kLeastFacing, 0.35);  // cosine of the angle to the normal
};

constexpr int kOctaveLayers = 3;
constexpr double kEdgeThreshold = 12, kSigma = 1.4;

cv::Mat Grey(const Image8& picture) {
  cv::Mat grey(picture.height, picture.width, CV_8U);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      grey.at<std::uint8_t>(y, x) =
          picture.channels == 1
              ? p[0]
              : static_cast<std::uint8_t>(0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2] + 0.5);
    }
  return grey;
}

/// Directions spread evenly over the sphere, without those from far below: figures stand.
std::vector<Eigen::Vector3d> Directions(int count) {
  constexpr double kLowest = -0.6;  // sine of the elevation
  std::vector<Eigen::Vector3d> directions;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = kLowest + (1 - kLowest) * (i + 0.5) / count;
    const double r = std::sqrt(std::max(0.0, 1 - z * z)), a = golden * i;
    directions.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return directions;
}

View ViewFrom(const PointsX3& points, const Eigen::Vector3d& direction, int size) {
  const double azimuth = std::atan2(direction.x(), -direction.y()) * 180 / std::numbers::pi;
  const double elevation =
      std::asin(std::clamp(direction.z(), -0.99, 0.99)) * 180 / std::numbers::pi;
  return FitView(points, azimuth, elevation, size, size);
}

struct Rendered {
  std::vector<SurfacePoint> points;
  Descriptors descriptors;
};

/// The point of the mesh at a pixel (centres at whole numbers); false beside the mesh or where it
/// is seen at a grazing angle.
bool PointAt(const Mesh& mesh, const PointsX3& normals, const RayScene& scene, const View& view,
             const Eigen::Vector2d& pixel, SurfacePoint& point) {
  const Eigen::Vector3d eye = view.Center();
  const Eigen::Vector3d ray = view.camera_from_world.rotation.conjugate() *
                              view.camera.Unproject(pixel + Eigen::Vector2d::Constant(0.5));
  const RayScene::Hit hit = scene.Cast(eye, ray);
  if (hit.face < 0) return false;
  const double facing = -normals.row(hit.face).dot(ray.normalized());
  if (facing < SurfaceFeatureTuning::kLeastFacing) return false;
  point.vertices = mesh.faces.row(hit.face).transpose();
  point.weights = {1 - hit.u - hit.v, hit.u, hit.v};
  return true;
}

Rendered FeaturesFrom(const Mesh& mesh, const PointsX3& normals, const RayScene& scene,
                      const Image8& texture, const View& view, int most) {
  RenderOptions options;
  options.texture = &texture;
  options.shading = 0;
  options.samples = 1;
  options.background = {128, 128, 128};
  const PictureFeatures found = FindFeatures(Render(mesh, scene, view, options), {}, most);
  Rendered rendered;
  std::vector<int> kept;
  for (int i = 0; i < SizeOf(found.pixels); ++i) {
    SurfacePoint point;
    if (!PointAt(mesh, normals, scene, view, found.pixels[i], point)) continue;
    rendered.points.push_back(point);
    kept.push_back(i);
  }
  rendered.descriptors.resize(SizeOf(kept), 128);
  for (int k = 0; k < SizeOf(kept); ++k)
    rendered.descriptors.row(k) = found.descriptors.row(kept[k]);
  return rendered;
}

}  // namespace

Image8 MaskOf(const PreparedView& view) {
  const GreyMask& grey = view.levels[0].grey;
  Image8 mask(grey.width, grey.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = InMask(grey.data[i]) ? 255 : 0;
  return mask;
}

PictureFeatures FindFeatures(const Image8& picture, const Image8& mask, int most) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(
      most, kOctaveLayers, SurfaceFeatureTuning::kContrast * kOctaveLayers, kEdgeThreshold, kSigma);
  std::vector<cv::KeyPoint> keys;
  cv::Mat found, mask_mat;
  if (!mask.empty()) mask_mat = Grey(mask);
  sift->detectAndCompute(Grey(picture), mask_mat, keys, found);
  PictureFeatures features;
  features.descriptors.resize(SizeOf(keys), 128);
  for (int i = 0; i < SizeOf(keys); ++i) {
    features.pixels.emplace_back(keys[i].pt.x, keys[i].pt.y);
    features.sizes.push_back(keys[i].size);
    const Eigen::Map<const Eigen::RowVectorXf> row(found.ptr<float>(i), 128);
    const float sum = std::max(row.sum(), 1e-6f);
    features.descriptors.row(i) = (row / sum).cwiseMax(0.0f).cwiseSqrt();
  }
  return features;
}

SurfaceFeatures::SurfaceFeatures(const Mesh& mesh, const Image8& texture,
                                 const SurfaceFeatureOptions& options, Progress* progress)
    : options_(options), diagonal_(BoundingDiagonal(mesh.points)) {
  if (!mesh.has_uvs())
    throw InputError("the template has no texture coordinates; pass the mesh that unwrap wrote");
  const RayScene scene(mesh.points, mesh.faces);
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  const std::vector<Eigen::Vector3d> directions = Directions(options.directions);
  std::vector<Rendered> rendered(directions.size());
  ReportProgress(progress, 0, "features of the template");
  ParallelFor(SizeOf(directions), [&](std::int64_t i) {
    rendered[i] = FeaturesFrom(mesh, normals, scene, texture,
                               ViewFrom(mesh.points, directions[i], options.size), options.most);
  });
  Eigen::Index count = 0;
  for (const Rendered& r : rendered) count += SizeOf(r.points);
  descriptors_.resize(count, 128);
  positions_.resize(count, 3);
  for (const Rendered& r : rendered)
    for (int k = 0; k < SizeOf(r.points); ++k) {
      descriptors_.row(SizeOf(points_)) = r.descriptors.row(k);
      positions_.row(SizeOf(points_)) = PositionOf(r.points[k], mesh.points);
      points_.push_back(r.points[k]);
    }
}

std::vector<FeatureMatch> SurfaceFeatures::Match(const PictureFeatures& picture) const {
  const int count = SizeOf(picture.pixels);
  std::vector<FeatureMatch> best(count);
  std::vector<int> feature(count, -1);
  const double apart = SurfaceFeatureTuning::kSamePlace * diagonal_;
  constexpr int kBlock = 64;
  ParallelBlocks(count, kBlock, [&](std::int64_t begin, std::int64_t end) {
    const Eigen::MatrixXf cosines =
        descriptors_ * picture.descriptors.middleRows(begin, end - begin).transpose();
    for (std::int64_t i = begin; i < end; ++i) {
      if (size() == 0) continue;
      const auto column = cosines.col(i - begin);
      Eigen::Index first = 0;
      const float top = column.maxCoeff(&first);
      float second = -1;
      for (Eigen::Index k = 0; k < column.size(); ++k)
        if (column[k] > second &&
            (positions_.row(k) - positions_.row(first)).squaredNorm() > apart * apart)
          second = column[k];
      // unit vectors: the squared distance is 2 - 2 cosine
      const double ratio = std::sqrt(std::max(0.0f, 1 - top) / std::max(1e-6f, 1 - second));
      best[i] = {points_[first], picture.pixels[i], top, ratio};
      feature[i] = static_cast<int>(first);
    }
  });
  std::map<int, int> owner;  // of each surface feature, the picture's feature that fits best
  for (int i = 0; i < count; ++i) {
    if (feature[i] < 0 || best[i].ratio > options_.best_ratio) continue;
    const auto [at, added] = owner.emplace(feature[i], i);
    if (!added && best[i].ratio < best[at->second].ratio) at->second = i;
  }
  std::vector<FeatureMatch> matches;
  for (const auto& [key, i] : owner) matches.push_back(best[i]);
  return matches;
}

}  // namespace keypose
