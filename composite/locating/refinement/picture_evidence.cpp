#include "composite/locating/refinement/picture_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "composite/locating/outline/shrunk.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct EvidenceTuning {
  // Neighbouring residuals err alike: one independent residual for each length of outline [px] and
  // each area of grey values [px^2]. A baked texture may lie a pixel beside its place over whole
  // limbs (docs/algorithms/locate.md), so a good matte must outweigh it.
  KEYPOSE_TUNED(double, kOutlineCorrelation, 8);
  KEYPOSE_TUNED(double, kGreyCorrelation, 700);
  KEYPOSE_TUNED(double, kEdgeWeight, 0.3);        // of inner edges over outlines
  KEYPOSE_TUNED(double, kSightingDeviation, 3);   // px, likewise
  KEYPOSE_TUNED(double, kLeastCorrelation, 0.1);  // of greys that are used; fur has little
};

constexpr double kClickDeviation = 2.5;     // px, in the whole picture
constexpr double kCornerDistortion = 0.02;  // deviation: a lens's, of the distance from the centre
constexpr double kSightingReach = 4;        // px
constexpr double kStep = 2;                 // px along an outline
constexpr int kEdgeReach = 5;               // px on each side
constexpr double kLeastEdge = 6;            // grey levels a pixel

double RobustWeight(double distance, double scale) {
  const double s2 = scale * scale, w = s2 / (s2 + distance * distance);
  return w * w;
}

double Truncated(double distance, double scale) {
  const double s2 = scale * scale, d2 = distance * distance;
  return s2 * d2 / (s2 + d2);
}

/// A matte that is worse than it is said to be counts less beside grey values.
double DeviationOf(const OutlineMatches& found, double offset_px, double expected_px) {
  std::vector<double> sizes;
  for (const OutlineMatch& match : found.matches)
    sizes.push_back(std::abs(match.distance_px - offset_px));
  if (sizes.empty()) return expected_px;
  return std::max(expected_px, 1.4826 * UpperMedian(std::move(sizes)));
}

void AddOutlines(NormalEquations& equations, const std::vector<SilhouettePoint>& silhouette,
                 const PictureEvidence& evidence, const Terms& terms) {
  const double reach_px = terms.reach_px;
  const OutlineMatches found = MatchOutlines(silhouette, evidence.outline, reach_px);
  const double variance =
      std::pow(DeviationOf(found, terms.matte_offset_px, evidence.matte_deviation_px), 2);
  // Both directions see the same outline, so each counts half.
  const double base = 0.5 / (variance * EvidenceTuning::kOutlineCorrelation);
  for (const OutlineMatch& match : found.matches) {
    const double distance = match.distance_px - terms.matte_offset_px;
    equations.Add(match.position, match.direction, distance,
                  base * match.length_px * RobustWeight(distance, reach_px / 2), true);
  }
}

void AddPoint(NormalEquations& equations, const Eigen::Vector3d& position,
              const Eigen::Vector2d& error, double deviation, double scale) {
  const double weight = RobustWeight(error.norm(), scale) / (deviation * deviation);
  equations.Add(position, Eigen::Vector2d::UnitX(), error.x(), weight);
  equations.Add(position, Eigen::Vector2d::UnitY(), error.y(), weight);
}

void AddGreys(NormalEquations& equations, const Figure& figure, const PictureEvidence& evidence,
              const GreyTexture& texture, const Placement& at) {
  const GreyMatches greys = MatchGreys(figure, texture, evidence.luma, evidence.matte, at);
  if (greys.correlation < EvidenceTuning::kLeastCorrelation || greys.deviation <= 0) return;
  const double base = 1 / (greys.deviation * greys.deviation * EvidenceTuning::kGreyCorrelation);
  for (const GreyMatches::Match& match : greys.matches)
    equations.Add(match.position, match.gradient, match.difference,
                  base * RobustWeight(match.difference, 2.5 * greys.deviation));
}

float LumaAt(const ImageF& luma, const Eigen::Vector2d& pixel) {
  const double x = std::clamp(pixel.x() - 0.5, 0.0, luma.width - 1.001);
  const double y = std::clamp(pixel.y() - 0.5, 0.0, luma.height - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  const float *top = luma.at(x0, y0), *low = luma.at(x0, y0 + 1);
  return (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * low[0] + u * low[1]);
}

/// Where the picture changes most across an inner outline, near it.
/// @return false when nothing stands out there
bool FindEdge(const ImageF& luma, const SilhouettePoint& point, double& offset) {
  double greatest = 0, second = 0;
  std::array<double, 2 * kEdgeReach + 1> slopes;
  for (int k = -kEdgeReach; k <= kEdgeReach; ++k) {
    const Eigen::Vector2d at = point.pixel + k * point.normal;
    slopes[k + kEdgeReach] = std::abs(static_cast<double>(LumaAt(luma, at + point.normal) -
                                                          LumaAt(luma, at - point.normal))) /
                             2;
  }
  int best = -1;
  for (int k = 1; k < 2 * kEdgeReach; ++k) {
    if (slopes[k] < slopes[k - 1] || slopes[k] < slopes[k + 1]) continue;
    if (slopes[k] > greatest) {
      second = greatest;
      greatest = slopes[k];
      best = k;
    } else
      second = std::max(second, slopes[k]);
  }
  if (best < 0 || greatest < kLeastEdge || second > 0.7 * greatest) return false;
  const double l = slopes[best - 1], m = slopes[best], r = slopes[best + 1];
  const double bend = l - 2 * m + r;
  offset = best - kEdgeReach + (bend < 0 ? 0.5 * (l - r) / bend : 0);
  return true;
}

void AddInnerEdges(NormalEquations& equations, const std::vector<SilhouettePoint>& silhouette,
                   const PictureEvidence& evidence) {
  const double base = EvidenceTuning::kEdgeWeight / EvidenceTuning::kOutlineCorrelation;
  for (const SilhouettePoint& point : silhouette) {
    double offset = 0;
    if (!point.inner || !FindEdge(evidence.luma, point, offset)) continue;
    equations.Add(point.position, point.normal, offset,
                  base * point.length_px * RobustWeight(offset, 2));
  }
}

/// Squared distance of the picture's corner from its centre, over the focal length's square: what
/// k1 is multiplied with there.
double CornerSquared(const Camera& camera) {
  return (std::pow(camera.width / camera.fx, 2) + std::pow(camera.height / camera.fy, 2)) / 4;
}

}  // namespace

PictureEvidence MakeEvidence(const Image8& picture, const Image8& matte, double deviation_px,
                             double scale) {
  PictureEvidence evidence;
  const int width = static_cast<int>(std::lround(picture.width * scale));
  const int height = static_cast<int>(std::lround(picture.height * scale));
  evidence.scale = static_cast<double>(width) / picture.width;
  evidence.luma = LumaOf(scale < 1 ? Shrunk(picture, width, height) : picture);
  if (!matte.empty()) {
    evidence.matte = scale < 1 ? Shrunk(matte, width, height) : matte;
    evidence.outline = MatteOutline(evidence.matte);
  }
  evidence.matte_deviation_px = std::max(0.5, deviation_px * evidence.scale);
  return evidence;
}

void SetSightings(PictureEvidence& evidence, const std::vector<Sighting>& sightings) {
  evidence.sightings = sightings;
  for (Sighting& sighting : evidence.sightings) sighting.pixel *= evidence.scale;
}

void SetClicks(PictureEvidence& evidence, const std::vector<Click>& clicks) {
  evidence.clicks = clicks;
  for (Click& click : evidence.clicks) click.pixel *= evidence.scale;
}

NormalEquations EquationsOf(const Figure& figure, const PictureEvidence& evidence,
                            const Placement& at, const Terms& terms, const Eigen::Vector3d& center,
                            double radius) {
  NormalEquations equations(at, center, radius);
  if (!evidence.outline.points().empty() || terms.edges) {
    const std::vector<SilhouettePoint> silhouette = FindSilhouette(figure, at, kStep, terms.edges);
    if (!evidence.outline.points().empty()) AddOutlines(equations, silhouette, evidence, terms);
    if (terms.edges) AddInnerEdges(equations, silhouette, evidence);
  }
  for (const Sighting& sighting : evidence.sightings) {
    const Eigen::Vector3d x = PositionOf(sighting.point, figure.points);
    AddPoint(equations, x, sighting.pixel - at.Project(x), EvidenceTuning::kSightingDeviation,
             kSightingReach);
  }
  for (const Click& click : evidence.clicks) {
    const Eigen::Vector3d x = PositionOf(click.point, figure.points);
    AddPoint(equations, x, click.pixel - at.Project(x), kClickDeviation * evidence.scale, 1e9);
  }
  if (terms.texture) AddGreys(equations, figure, evidence, *terms.texture, at);
  return equations;
}

NormalEquations EquationsOf(const Figure& figure, const PictureEvidence& evidence,
                            const Placement& at, const Terms& terms) {
  return EquationsOf(figure, evidence, at, terms, figure.center, figure.radius);
}

void AddLensPrior(NormalEquations& equations, const LensPrior& prior, double scale,
                  double matte_offset_px) {
  const Camera& camera = equations.at().camera;
  if (prior.focal_free && prior.focal_deviation > 0)
    equations.AddPrior(kLogFocal, std::log(prior.focal_px * scale / camera.fx),
                       1 / std::pow(prior.focal_deviation, 2));
  if (prior.k1_free)
    equations.AddPrior(kK1, -camera.k1, 1 / std::pow(kCornerDistortion / CornerSquared(camera), 2));
  if (prior.matte_offset_deviation > 0)
    equations.AddPrior(kMatteOffset, -matte_offset_px,
                       1 / std::pow(prior.matte_offset_deviation * scale, 2));
}

Misfit MisfitOf(const Figure& figure, const PictureEvidence& evidence, const Placement& at,
                double reach_px, double matte_offset_px) {
  Misfit misfit;
  if (!evidence.outline.points().empty()) {
    const OutlineMatches found =
        MatchOutlines(FindSilhouette(figure, at, kStep), evidence.outline, reach_px);
    const double variance = std::pow(evidence.matte_deviation_px, 2);
    const double base = 0.5 / EvidenceTuning::kOutlineCorrelation;
    for (const OutlineMatch& match : found.matches)
      misfit.cost += base * match.length_px *
                     Truncated(match.distance_px - matte_offset_px, reach_px) / variance;
    misfit.cost += base * found.unmatched_px * reach_px * reach_px / (2 * variance);
    misfit.count += base * found.length_px;
  }
  for (const Sighting& sighting : evidence.sightings) {
    const double error =
        (sighting.pixel - at.Project(PositionOf(sighting.point, figure.points))).norm();
    misfit.cost +=
        Truncated(error, kSightingReach) / std::pow(EvidenceTuning::kSightingDeviation, 2);
    misfit.count += 2;
  }
  for (const Click& click : evidence.clicks) {
    const double error = (click.pixel - at.Project(PositionOf(click.point, figure.points))).norm();
    misfit.cost += std::pow(error / (kClickDeviation * evidence.scale), 2);
    misfit.count += 2;
  }
  return misfit;
}

NormalEquations SmoothOutlineEquations(const Figure& figure, const Placement& at) {
  NormalEquations equations(at, figure.center, figure.radius);
  const PointsX3 normals = VertexNormals(figure.points, figure.faces);
  const Eigen::Vector3d eye = at.camera_from_mesh.Inverse().translation;
  const Eigen::VectorXd facing =
      ((-figure.points).rowwise() + eye.transpose()).cwiseProduct(normals).rowwise().sum();
  for (Eigen::Index f = 0; f < figure.faces.rows(); ++f) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    int crossings = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = figure.faces(f, k), b = figure.faces(f, (k + 1) % 3);
      if ((facing[a] > 0) == (facing[b] > 0)) continue;
      const double t = facing[a] / (facing[a] - facing[b]);
      position += 0.5 * ((1 - t) * figure.points.row(a) + t * figure.points.row(b)).transpose();
      normal += 0.5 * ((1 - t) * normals.row(a) + t * normals.row(b)).transpose();
      ++crossings;
    }
    if (crossings != 2) continue;
    const Eigen::Vector3d x = at.camera_from_mesh * position;
    if (x.z() <= 0) continue;
    const Eigen::Vector2d direction =
        DerivativesAt(at.camera, x).by_point * (at.camera_from_mesh.rotation * normal);
    if (direction.norm() > 0) equations.Add(position, direction.normalized(), 0, 1);
  }
  return equations;
}

}  // namespace keypose::composite
