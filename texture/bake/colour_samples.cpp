#include "texture/bake/colour_samples.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Samples are compared by their colour, and by the mean colour over 2^3 times the width.
constexpr float kBandLevels = 3;
/// Tuned on held-out photographs of the synthetic character, the plush dog and the skull
/// (docs/algorithms/bake.md) and on the glossy sphere of bake_test.
struct AgreementTuning {
  /// square root of linear light: smaller colour differences from the median keep full agreement
  /// (shading that turns with the table, and single hairs); removing more of these makes the
  /// prediction of held-out photographs worse
  KEYPOSE_TUNED(float, kLeastScale, 0.35f);
  /// median differences of the views from each other: differences up to this many keep full
  /// agreement too
  KEYPOSE_TUNED(float, kScale, 3);
  /// factor of the difference of colours darker than the median: these are not lamps, and shadows
  /// and hairs lose weight at twice the difference
  KEYPOSE_TUNED(float, kDark, 0.5f);
};

using Weighted = std::vector<std::pair<float, float>>;  // value, weight

float WeightedMedian(Weighted& values) {
  std::sort(values.begin(), values.end());
  float all = 0, below = 0;
  for (const auto& v : values) all += v.second;
  for (const auto& v : values)
    if (2 * (below += v.second) >= all) return v.first;
  return values.back().first;
}

/// The weighted median of one band's colours.
Vector3f MiddleOf(const std::vector<ColorSample>& samples, Vector3f ColorSample::*band,
                  Weighted& scratch) {
  Vector3f middle;
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      scratch[i] = {(samples[i].*band)[c], samples[i].consensus_weight};
    middle[c] = WeightedMedian(scratch);
  }
  return middle;
}

/// Lowers the agreement of samples far from the median, relative to the spread of the others. Where
/// lit and shaded views are about equally frequent, all keep their weight, and no seam appears
/// where the majority changes; a single highlight among views that agree is removed.
void WeighAgreement(std::vector<ColorSample>& samples, double strictness) {
  if (samples.size() < 3 || strictness <= 0) return;
  Weighted scratch(samples.size());
  const Vector3f middle = MiddleOf(samples, &ColorSample::root, scratch),
                 low_middle = MiddleOf(samples, &ColorSample::low_root, scratch);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].agreement = std::sqrt((samples[i].root - middle).squaredNorm() +
                                     (samples[i].low_root - low_middle).squaredNorm());
    if ((samples[i].root - middle).sum() <= 0) samples[i].agreement *= AgreementTuning::kDark;
    scratch[i] = {samples[i].agreement, samples[i].consensus_weight};
  }
  const float scale =
      std::max(AgreementTuning::kLeastScale, AgreementTuning::kScale * WeightedMedian(scratch));
  for (ColorSample& sample : samples) {
    const float u = sample.agreement / scale;
    sample.agreement = static_cast<float>(std::pow(1 + u * u * u * u, -strictness / 3));
  }
}

/// The level of the photograph's pyramid on which this many pixels are one; 0 for less than a
/// pixel.
float LevelOf(double pixels) {
  return pixels > 1 ? 0.5f * std::log2(static_cast<float>(pixels)) : 0;
}

Vector3d Mixed(const PointsX3& rows, const Mesh& mesh, const SurfacePoint& point) {
  Vector3d x = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    x += static_cast<double>(point.weights[k]) * rows.row(mesh.faces(point.face, k)).transpose();
  return x;
}

}  // namespace

ColorSampler::ColorSampler(const Mesh& mesh, const std::vector<BakeView>& views,
                           const std::vector<Vector3f>& gains, const std::vector<Warp>& warps,
                           const std::vector<char>& used, int texture_size, double max_angle_deg,
                           double strictness)
    : mesh_(mesh),
      views_(views),
      gains_(gains),
      warps_(warps),
      least_cosine_(std::cos(max_angle_deg * M_PI / 180)),
      strictness_(strictness) {
  face_normals_ = FaceNormals(mesh.points, mesh.faces);
  vertex_normals_ = VertexNormals(mesh.points, mesh.faces);
  FindViews(used);
  WeighSharpness();
  MeasureTexels(texture_size);
}

void ColorSampler::FindViews(const std::vector<char>& used) {
  facing_.resize(mesh_.face_count());
  ParallelFor(
      mesh_.face_count(),
      [&](std::int64_t f) {
        const Vector3d n = face_normals_.row(f);
        for (int v = 0; v < view_count(); ++v) {
          if (views_[v].sees_nothing() || !used[v]) continue;
          for (int k = 0; k < 3; ++k) {
            const Vector3d to_eye =
                views_[v].center() - mesh_.points.row(mesh_.faces(f, k)).transpose();
            // The normal at a corner of a large face may face the camera slightly less than at its
            // middle.
            if (n.dot(to_eye) < (least_cosine_ - 0.1) * to_eye.norm()) continue;
            facing_[f].push_back(v);
            break;
          }
        }
      },
      256);
}

void ColorSampler::WeighSharpness() {
  std::vector<double> known;
  for (const BakeView& view : views_)
    if (view.sharpness() > 0) known.push_back(view.sharpness());
  sharpness_.assign(views_.size(), 1.0);
  if (known.empty()) return;
  const double median = UpperMedian(std::move(known));
  for (std::size_t v = 0; v < views_.size(); ++v)
    if (views_[v].sharpness() > 0)
      sharpness_[v] = std::clamp(views_[v].sharpness() / median, 0.2, 1.5);
}

void ColorSampler::MeasureTexels(int texture_size) {
  areas_ = FaceAreas(mesh_.points, mesh_.faces);
  area_per_texel_.resize(mesh_.face_count());
  for (int f = 0; f < mesh_.face_count(); ++f) {
    const auto a = mesh_.uvs.row(mesh_.uv_faces(f, 0)), b = mesh_.uvs.row(mesh_.uv_faces(f, 1)),
               c = mesh_.uvs.row(mesh_.uv_faces(f, 2));
    const double texels = 0.5 * std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) *
                          texture_size * texture_size;
    area_per_texel_[f] = areas_[f] / std::max(texels, 1e-3);
  }
}

void ColorSampler::CollectColorSamples(const SurfacePoint& point, double texels,
                                       std::vector<ColorSample>& samples) const {
  samples.clear();
  const Vector3d x = Mixed(mesh_.points, mesh_, point), flat = face_normals_.row(point.face);
  Vector3d smooth = Mixed(vertex_normals_, mesh_, point);
  smooth = smooth.squaredNorm() > 1e-12 ? smooth.normalized().eval() : flat;
  for (const int v : facing_[point.face]) {
    const Vector3d to_eye = (views_[v].center() - x).normalized();
    if (flat.dot(to_eye) < least_cosine_) continue;
    const Sighting sighting = See(v, x);
    if (sighting.trust <= 0) continue;
    const double cosine = std::max(smooth.dot(to_eye), least_cosine_),
                 focal = views_[v].view().camera.fx / sighting.depth;
    AddColorSample(v, sighting,
                   focal * focal * cosine * area_per_texel_[point.face] * texels * texels, cosine,
                   samples);
  }
  WeighAgreement(samples, strictness_);
}

Sighting ColorSampler::See(int view, const Vector3d& x) const {
  Sighting sighting = views_[view].See(x);
  if (sighting.trust > 0 && !warps_.empty()) sighting.pixel = warps_[view].Moved(sighting.pixel);
  return sighting;
}

void ColorSampler::AddColorSample(int view, const Sighting& sighting, double pixels, double cosine,
                                  std::vector<ColorSample>& samples) const {
  const BakeView& from = views_[view];
  const float level = LevelOf(pixels);
  const Eigen::Vector2f pixel = sighting.pixel.cast<float>();
  const Sample fine = from.ColorAt(pixel, level), low = from.ColorAt(pixel, level + kBandLevels);
  if (fine.alpha <= 0 || low.alpha <= 0) return;
  ColorSample sample;
  sample.view = view;
  sample.fine = fine.color.cwiseProduct(gains_[view]);
  sample.root = sample.fine.cwiseSqrt();
  sample.low_root = low.color.cwiseProduct(gains_[view]).cwiseSqrt();
  sample.weight = from.weight() * static_cast<float>(sighting.trust * pixels * sharpness_[view]);
  sample.consensus_weight =
      from.weight() * static_cast<float>(sighting.trust * std::min(1.0, 2 * cosine));
  // A clipped pixel only gives a lower bound of the brightness: a highlight, or an overexposed
  // photograph.
  if (fine.color.minCoeff() > 0.9f) {
    sample.weight *= 0.1f;
    sample.consensus_weight *= 0.3f;
  }
  sample.quality = static_cast<float>(sample.weight * cosine * cosine);
  sample.trust = sighting.trust;
  if (sample.weight > 0) samples.push_back(sample);
}

bool ColorSampler::Prepare(int view, int face, FaceSight& sight) const {
  // Within this many pixels perspective and lens distortion are linear to a hundredth of a pixel.
  constexpr float kFlatPixels = 48;
  const View& from = views_[view].view();
  sight.view = view;
  for (int k = 0; k < 3; ++k) {
    const Vector3d x =
        from.camera_from_world * mesh_.points.row(mesh_.faces(face, k)).transpose().eval();
    if (!(x.z() > 0)) return false;
    const Eigen::Vector2d pixel = from.camera.Project(x);
    sight.pixels.col(k) = (warps_.empty() ? pixel : warps_[view].Moved(pixel)).cast<float>();
    sight.depths[k] = static_cast<float>(x.z());
  }
  const auto side = [&](int a, int b) {
    return (sight.pixels.col(a) - sight.pixels.col(b)).norm();
  };
  sight.flat = std::max({side(0, 1), side(1, 2), side(2, 0)}) < kFlatPixels;
  const Vector3d middle = Mixed(mesh_.points, mesh_, {face, Vector3f::Constant(1.0f / 3)});
  const double focal = from.camera.fx / sight.depths.mean();
  const double cosine = std::max(
      face_normals_.row(face).dot((views_[view].center() - middle).normalized()), least_cosine_);
  sight.level = LevelOf(focal * focal * cosine * area_per_texel_[face]);
  return true;
}

float ColorSampler::SeeExactly(int view, const SurfacePoint& point, Eigen::Vector2f& pixel) const {
  const Sighting sighting = See(view, Mixed(mesh_.points, mesh_, point));
  pixel = sighting.pixel.cast<float>();
  return sighting.trust;
}

FaceViews ColorSampler::LookAtFace(int face) const {
  constexpr int kPoints = 4;
  constexpr float kThird = 1.0f / 3, kMost = 0.7f, kRest = 0.15f;
  const Vector3f weights[kPoints] = {{kThird, kThird, kThird},
                                     {kMost, kRest, kRest},
                                     {kRest, kMost, kRest},
                                     {kRest, kRest, kMost}};
  // Each point represents a quarter of the face.
  const double texels = area_per_texel_[face] > 0
                            ? std::max(1.0, 0.5 * std::sqrt(areas_[face] / area_per_texel_[face]))
                            : 1;
  FaceViews result;
  std::vector<LabelCandidate> sums(views_.size(),
                                   {0, 0, Vector3f::Zero(), Vector3f::Zero(), 0, 1, 0});
  std::vector<float> trusted(views_.size(), 0);  // weights without agreement
  std::vector<ColorSample> samples;
  float total = 0;
  for (const Vector3f& w : weights) {
    CollectColorSamples({face, w}, texels, samples);
    for (const ColorSample& sample : samples) {
      LabelCandidate& sum = sums[sample.view];
      const float weight = sample.weight * sample.agreement;
      sum.quality += sample.quality;
      sum.weight += weight / sample.trust;
      trusted[sample.view] += sample.weight / sample.trust;
      sum.agreement = std::min(sum.agreement, sample.agreement);
      sum.color += sample.root;
      sum.linear += sample.fine;
      sum.seen += 1;
      result.mean += weight * sample.fine;
      total += weight;
    }
  }
  if (total > 0) result.mean /= total;
  for (const int v : facing_[face]) {
    const LabelCandidate& sum = sums[v];
    if (!(sum.quality > 0)) continue;
    // A view is less suitable for a face if it sees only a part of it, or if a part differs from
    // the other views.
    const float seen = sum.seen / kPoints, agreement = std::max(sum.agreement, 1e-6f);
    result.candidates.push_back({v, sum.quality * agreement * seen * seen, sum.color / sum.seen,
                                 sum.linear / sum.seen, seen, agreement, sum.weight / kPoints,
                                 std::max(sum.weight / trusted[v], 1e-6f)});
  }
  return result;
}

std::vector<FaceViews> ColorSampler::LookAtFaces() const {
  std::vector<FaceViews> faces(mesh_.face_count());
  ParallelFor(
      mesh_.face_count(), [&](std::int64_t f) { faces[f] = LookAtFace(static_cast<int>(f)); }, 64);
  return faces;
}

}  // namespace keypose::texture
