#include "texture/bake_votes.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/parallel.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Votes are compared by their colour, and by that of 2^3 times the width.
constexpr float kBandLevels = 3;
/// Colours (square root of linear light) this far from what most views say are never doubted: shading that turns with the table, and
/// single hairs. Held-out photographs are predicted the worse the more of these is left out.
constexpr float kLeastScale = 0.35f;
/// Where the views differ among themselves, so many times their median difference from the middle is not doubted either.
constexpr float kScale = 3;
/// What is darker than the middle is no lamp: shadows and hairs are doubted at twice the distance.
constexpr float kDark = 0.5f;

using Weighted = std::vector<std::pair<float, float>>;  // value, weight

float WeightedMedian(Weighted& values) {
  std::sort(values.begin(), values.end());
  float all = 0, below = 0;
  for (const auto& v : values) all += v.second;
  for (const auto& v : values)
    if (2 * (below += v.second) >= all) return v.first;
  return values.back().first;
}

/// The middle of one band's colours, by say.
Vector3f MiddleOf(const std::vector<Vote>& votes, Vector3f Vote::*band, Weighted& scratch) {
  Vector3f middle;
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < votes.size(); ++i) scratch[i] = {(votes[i].*band)[c], votes[i].say};
    middle[c] = WeightedMedian(scratch);
  }
  return middle;
}

/// Lowers the agreement of votes far from what most others say, measured by how far the others lie apart: where lit and shaded views are
/// about equally many all stay, and no seam appears where the majority turns; one highlight among views that agree goes.
void WeighAgreement(std::vector<Vote>& votes, double strictness) {
  if (votes.size() < 3 || strictness <= 0) return;
  Weighted scratch(votes.size());
  const Vector3f middle = MiddleOf(votes, &Vote::root, scratch), low_middle = MiddleOf(votes, &Vote::low_root, scratch);
  for (std::size_t i = 0; i < votes.size(); ++i) {
    votes[i].agreement = std::sqrt((votes[i].root - middle).squaredNorm() + (votes[i].low_root - low_middle).squaredNorm());
    if ((votes[i].root - middle).sum() <= 0) votes[i].agreement *= kDark;
    scratch[i] = {votes[i].agreement, votes[i].say};
  }
  const float scale = std::max(kLeastScale, kScale * WeightedMedian(scratch));
  for (Vote& vote : votes) {
    const float u = vote.agreement / scale;
    vote.agreement = static_cast<float>(std::pow(1 + u * u * u * u, -strictness / 3));
  }
}

/// The level of the photograph's pyramid on which so many pixels are one; 0 for less than a pixel.
float LevelOf(double pixels) { return pixels > 1 ? 0.5f * std::log2(static_cast<float>(pixels)) : 0; }

Vector3d Mixed(const PointsX3& rows, const Mesh& mesh, const SurfacePoint& point) {
  Vector3d x = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) x += static_cast<double>(point.weights[k]) * rows.row(mesh.faces(point.face, k)).transpose();
  return x;
}

}  // namespace

Witnesses::Witnesses(const Mesh& mesh, const std::vector<BakeView>& views, const std::vector<Vector3f>& gains,
                     const std::vector<Warp>& warps, const std::vector<char>& used, int texture_size, double max_angle_deg,
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

void Witnesses::FindViews(const std::vector<char>& used) {
  facing_.resize(mesh_.face_count());
  ParallelFor(
      mesh_.face_count(),
      [&](std::int64_t f) {
        const Vector3d n = face_normals_.row(f);
        for (int v = 0; v < view_count(); ++v) {
          if (views_[v].sees_nothing() || !used[v]) continue;
          for (int k = 0; k < 3; ++k) {
            const Vector3d to_eye = views_[v].center() - mesh_.points.row(mesh_.faces(f, k)).transpose();
            // A corner may see the eye a little more aslant than the middle of a large face does.
            if (n.dot(to_eye) < (least_cosine_ - 0.1) * to_eye.norm()) continue;
            facing_[f].push_back(v);
            break;
          }
        }
      },
      256);
}

void Witnesses::WeighSharpness() {
  std::vector<double> known;
  for (const BakeView& view : views_)
    if (view.sharpness() > 0) known.push_back(view.sharpness());
  sharpness_.assign(views_.size(), 1.0);
  if (known.empty()) return;
  std::nth_element(known.begin(), known.begin() + known.size() / 2, known.end());
  const double median = known[known.size() / 2];
  for (std::size_t v = 0; v < views_.size(); ++v)
    if (views_[v].sharpness() > 0) sharpness_[v] = std::clamp(views_[v].sharpness() / median, 0.2, 1.5);
}

void Witnesses::MeasureTexels(int texture_size) {
  areas_ = FaceAreas(mesh_.points, mesh_.faces);
  area_per_texel_.resize(mesh_.face_count());
  for (int f = 0; f < mesh_.face_count(); ++f) {
    const auto a = mesh_.uvs.row(mesh_.uv_faces(f, 0)), b = mesh_.uvs.row(mesh_.uv_faces(f, 1)), c = mesh_.uvs.row(mesh_.uv_faces(f, 2));
    const double texels = 0.5 * std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) * texture_size * texture_size;
    area_per_texel_[f] = areas_[f] / std::max(texels, 1e-3);
  }
}

void Witnesses::CollectVotes(const SurfacePoint& point, double texels, std::vector<Vote>& votes) const {
  votes.clear();
  const Vector3d x = Mixed(mesh_.points, mesh_, point), flat = face_normals_.row(point.face);
  Vector3d smooth = Mixed(vertex_normals_, mesh_, point);
  smooth = smooth.squaredNorm() > 1e-12 ? smooth.normalized().eval() : flat;
  for (const int v : facing_[point.face]) {
    const Vector3d to_eye = (views_[v].center() - x).normalized();
    if (flat.dot(to_eye) < least_cosine_) continue;
    const Sighting sighting = See(v, x);
    if (sighting.trust <= 0) continue;
    const double cosine = std::max(smooth.dot(to_eye), least_cosine_), focal = views_[v].view().camera.fx / sighting.depth;
    AddVote(v, sighting, focal * focal * cosine * area_per_texel_[point.face] * texels * texels, cosine, votes);
  }
  WeighAgreement(votes, strictness_);
}

Sighting Witnesses::See(int view, const Vector3d& x) const {
  Sighting sighting = views_[view].See(x);
  if (sighting.trust > 0 && !warps_.empty()) sighting.pixel = warps_[view].Moved(sighting.pixel);
  return sighting;
}

void Witnesses::AddVote(int view, const Sighting& sighting, double pixels, double cosine, std::vector<Vote>& votes) const {
  const BakeView& from = views_[view];
  const float level = LevelOf(pixels);
  const Eigen::Vector2f pixel = sighting.pixel.cast<float>();
  const Sample fine = from.ColorAt(pixel, level), low = from.ColorAt(pixel, level + kBandLevels);
  if (fine.alpha <= 0 || low.alpha <= 0) return;
  Vote vote;
  vote.view = view;
  vote.fine = fine.color.cwiseProduct(gains_[view]);
  vote.root = vote.fine.cwiseSqrt();
  vote.low_root = low.color.cwiseProduct(gains_[view]).cwiseSqrt();
  vote.weight = from.say() * static_cast<float>(sighting.trust * pixels * sharpness_[view]);
  vote.say = from.say() * static_cast<float>(sighting.trust * std::min(1.0, 2 * cosine));
  // A clipped pixel tells only that the surface was at least this bright: a highlight, or an overexposed photograph.
  if (fine.color.minCoeff() > 0.9f) vote.weight *= 0.1f, vote.say *= 0.3f;
  vote.quality = static_cast<float>(vote.weight * cosine * cosine);
  vote.trust = sighting.trust;
  if (vote.weight > 0) votes.push_back(vote);
}

bool Witnesses::Prepare(int view, int face, FaceSight& sight) const {
  // Within so many pixels perspective and lens are straight to a hundredth of a pixel.
  constexpr float kFlatPixels = 48;
  const View& from = views_[view].view();
  sight.view = view;
  for (int k = 0; k < 3; ++k) {
    const Vector3d x = from.camera_from_world * mesh_.points.row(mesh_.faces(face, k)).transpose().eval();
    if (!(x.z() > 0)) return false;
    const Eigen::Vector2d pixel = from.camera.Project(x);
    sight.pixels.col(k) = (warps_.empty() ? pixel : warps_[view].Moved(pixel)).cast<float>();
    sight.depths[k] = static_cast<float>(x.z());
  }
  const auto side = [&](int a, int b) { return (sight.pixels.col(a) - sight.pixels.col(b)).norm(); };
  sight.flat = std::max({side(0, 1), side(1, 2), side(2, 0)}) < kFlatPixels;
  const Vector3d middle = Mixed(mesh_.points, mesh_, {face, Vector3f::Constant(1.0f / 3)});
  const double focal = from.camera.fx / sight.depths.mean();
  const double cosine = std::max(face_normals_.row(face).dot((views_[view].center() - middle).normalized()), least_cosine_);
  sight.level = LevelOf(focal * focal * cosine * area_per_texel_[face]);
  return true;
}

float Witnesses::SeeExactly(int view, const SurfacePoint& point, Eigen::Vector2f& pixel) const {
  const Sighting sighting = See(view, Mixed(mesh_.points, mesh_, point));
  pixel = sighting.pixel.cast<float>();
  return sighting.trust;
}

FaceViews Witnesses::LookAtFace(int face) const {
  constexpr int kPoints = 4;
  constexpr float kThird = 1.0f / 3, kMost = 0.7f, kRest = 0.15f;
  const Vector3f weights[kPoints] = {{kThird, kThird, kThird}, {kMost, kRest, kRest}, {kRest, kMost, kRest}, {kRest, kRest, kMost}};
  // Each point stands for a quarter of the face.
  const double texels = area_per_texel_[face] > 0 ? std::max(1.0, 0.5 * std::sqrt(areas_[face] / area_per_texel_[face])) : 1;
  FaceViews result;
  std::vector<LabelCandidate> sums(views_.size(), {0, 0, Vector3f::Zero(), Vector3f::Zero(), 0, 1, 0});
  std::vector<float> trusted(views_.size(), 0);  // weights without agreement
  std::vector<Vote> votes;
  float total = 0;
  for (const Vector3f& w : weights) {
    CollectVotes({face, w}, texels, votes);
    for (const Vote& vote : votes) {
      LabelCandidate& sum = sums[vote.view];
      const float weight = vote.weight * vote.agreement;
      sum.quality += vote.quality;
      sum.weight += weight / vote.trust;
      trusted[vote.view] += vote.weight / vote.trust;
      sum.agreement = std::min(sum.agreement, vote.agreement);
      sum.color += vote.root;
      sum.linear += vote.fine;
      sum.seen += 1;
      result.mean += weight * vote.fine;
      total += weight;
    }
  }
  if (total > 0) result.mean /= total;
  for (const int v : facing_[face]) {
    const LabelCandidate& sum = sums[v];
    if (!(sum.quality > 0)) continue;
    // A view that sees a part of the face only, or a part of it otherwise than the others, is no good for all of it.
    const float seen = sum.seen / kPoints, agreement = std::max(sum.agreement, 1e-6f);
    result.candidates.push_back({v, sum.quality * agreement * seen * seen, sum.color / sum.seen, sum.linear / sum.seen, seen, agreement,
                                 sum.weight / kPoints, std::max(sum.weight / trusted[v], 1e-6f)});
  }
  return result;
}

std::vector<FaceViews> Witnesses::LookAtFaces() const {
  std::vector<FaceViews> faces(mesh_.face_count());
  ParallelFor(
      mesh_.face_count(), [&](std::int64_t f) { faces[f] = LookAtFace(static_cast<int>(f)); }, 64);
  return faces;
}

}  // namespace keypose::texture
