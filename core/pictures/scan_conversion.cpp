#include "core/pictures/scan_conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/values/size_of.h"

namespace keypose {
namespace {

/// Rows of pixels in a band.
constexpr int kBand = 8;
/// A vertex is beside the camera if its depth is less than this share of its distance.
constexpr double kBeside = 1e-3;

/// The pixel that holds a coordinate, within [first, last].
int PixelOf(double coordinate, int first, int last) {
  return static_cast<int>(std::clamp(std::floor(coordinate), double(first), double(last)));
}

}  // namespace

/// A face's edges, for testing samples. Edge k is opposite to corner k.
struct ScanConversion::Face {
  /// `sign` * At is twice the area of the triangle that a point makes with the edge, and negative
  /// on the side where the face is not. Two faces compute it from the same corner of their common
  /// edge, so that rounding cannot put a point outside both.
  struct Edge {
    double from_x, from_y, dx, dy, sign;
    double At(double x, double y) const { return dx * (y - from_y) - dy * (x - from_x); }
    double Step(double x, double y) const { return dx * y - dy * x; }
  };
  std::array<Corner, 3> corner;
  std::array<Edge, 3> edge;

  Face(const ScanConversion& scan, int face) {
    const auto f = scan.faces_->row(face);
    for (int k = 0; k < 3; ++k) corner[k] = scan.corners_[f[k]];
    const double ux = corner[1].x - corner[0].x, uy = corner[1].y - corner[0].y;
    const double vx = corner[2].x - corner[0].x, vy = corner[2].y - corner[0].y;
    const double side = ux * vy - uy * vx < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) {
      const int i = f[(k + 1) % 3], j = f[(k + 2) % 3];
      const Corner &a = scan.corners_[std::min(i, j)], &b = scan.corners_[std::max(i, j)];
      edge[k] = {a.x, a.y, b.x - a.x, b.y - a.y, i < j ? side : -side};
    }
  }

  double InverseDepth(const std::array<double, 3>& areas) const {
    return (areas[0] * corner[0].inverse_depth + areas[1] * corner[1].inverse_depth +
            areas[2] * corner[2].inverse_depth) /
           (areas[0] + areas[1] + areas[2]);
  }

  RayScene::Hit HitAt(int face, const Eigen::Vector2d& at) const {
    std::array<double, 3> weights;  // areas on the face instead of in the picture
    double areas = 0, sum = 0;
    for (int k = 0; k < 3; ++k) {
      // A face without area in the picture may have rounded ones of either sign.
      const double area = std::max(0.0, edge[k].sign * edge[k].At(at.x(), at.y()));
      weights[k] = area * corner[k].inverse_depth;
      areas += area;
      sum += weights[k];
    }
    if (!(sum > 0)) return {face, 1 / corner[0].inverse_depth, 0, 0};
    return {face, areas / sum, weights[1] / sum, weights[2] / sum};
  }
};

std::optional<ScanConversion> ScanConversion::Of(const PointsX3& points, const FacesX3& faces,
                                                 const View& view,
                                                 std::vector<Eigen::Vector2d> pattern) {
  const Camera& c = view.camera;
  if (c.distorted()) return std::nullopt;
  ScanConversion scan(faces);
  scan.pattern_ = std::move(pattern);
  scan.width_ = c.width;
  scan.height_ = c.height;
  scan.corners_.resize(static_cast<std::size_t>(points.rows()));
  const Eigen::Matrix3d rotation = view.camera_from_world.rotation.toRotationMatrix();
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Eigen::Vector3d x =
        rotation * points.row(v).transpose() + view.camera_from_world.translation;
    if (!(x.z() > kBeside * x.norm()) || !x.allFinite()) return std::nullopt;
    const Eigen::Vector2d pixel = c.Project(x);
    scan.corners_[v] = {pixel.x(), pixel.y(), 1 / x.z()};
  }
  scan.FillBands();
  return scan;
}

void ScanConversion::FillBands() {
  bands_.resize(static_cast<std::size_t>((height_ + kBand - 1) / kBand));
  for (int face = 0; face < static_cast<int>(faces_->rows()); ++face) {
    const auto f = faces_->row(face);
    const auto [low, high] = std::minmax({corners_[f[0]].y, corners_[f[1]].y, corners_[f[2]].y});
    if (high < 0 || low >= height_) continue;
    const int first = PixelOf(low, 0, height_ - 1) / kBand,
              last = PixelOf(high, 0, height_ - 1) / kBand;
    for (int band = first; band <= last; ++band) bands_[band].push_back(face);
  }
}

/// One call of Fill: its samples so far.
class ScanConversion::Filling {
 public:
  Filling(const ScanConversion& scan, const PixelBox& box, const std::vector<int>& places)
      : scan_(scan),
        box_(box),
        places_(places),
        width_(std::max(0, box.x1 - box.x0)),
        count_(SizeOf(scan.pattern_)) {
    std::size_t wanted = static_cast<std::size_t>(width_) * std::max(0, box.y1 - box.y0);
    if (!places.empty())
      wanted = std::count_if(places.begin(), places.end(), [](int place) { return place >= 0; });
    face_.assign(wanted * count_, -1);
    inverse_depth_.assign(wanted * count_, 0);
    for (auto& step : steps_) step.resize(count_);
  }

  void Add(int id, int y0, int y1) {
    const Face face(scan_, id);
    const auto& [a, b, c] = face.corner;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    if (right < box_.x0 || left >= box_.x1 || bottom < y0 || top >= y1) return;
    const int from = PixelOf(left, box_.x0, box_.x1 - 1), to = PixelOf(right, box_.x0, box_.x1 - 1);
    const int first = PixelOf(top, y0, y1 - 1), last = PixelOf(bottom, y0, y1 - 1);
    bool stepped = false;
    for (int y = first; y <= last; ++y)
      for (int x = from; x <= to; ++x) {
        const int place = PlaceOf(x, y);
        if (place < 0) continue;
        if (!stepped) {
          MakeSteps(face);
          stepped = true;
        }
        AddToPixel(face, id, x, y, static_cast<std::size_t>(place) * count_);
      }
  }

  void Finish(std::vector<RayScene::Hit>& hits) const {
    hits.assign(face_.size(), {});
    std::optional<Face> face;
    int of = -1;  // neighbours often see the same face
    for (int y = box_.y0; y < box_.y1; ++y)
      for (int x = box_.x0; x < box_.x1; ++x) {
        const int place = PlaceOf(x, y);
        for (int s = 0; place >= 0 && s < count_; ++s) {
          const std::size_t sample = static_cast<std::size_t>(place) * count_ + s;
          const int id = face_[sample];
          if (id < 0) continue;
          if (id != of) {
            face.emplace(scan_, id);
            of = id;
          }
          hits[sample] = face->HitAt(id, Eigen::Vector2d(x, y) + scan_.pattern_[s]);
        }
      }
  }

 private:
  int PlaceOf(int x, int y) const {
    const int pixel = (y - box_.y0) * width_ + (x - box_.x0);
    return places_.empty() ? pixel : places_[pixel];
  }

  /// What the areas of a pixel's samples have beyond those at the pixel's corner.
  void MakeSteps(const Face& face) {
    for (int k = 0; k < 3; ++k) {
      most_[k] = -std::numeric_limits<double>::infinity();
      for (int s = 0; s < count_; ++s) {
        const Eigen::Vector2d& at = scan_.pattern_[s];
        steps_[k][s] = face.edge[k].sign * face.edge[k].Step(at.x(), at.y());
        most_[k] = std::max(most_[k], steps_[k][s]);
      }
    }
  }

  void AddToPixel(const Face& face, int id, int x, int y, std::size_t first) {
    std::array<double, 3> at;
    for (int k = 0; k < 3; ++k) at[k] = face.edge[k].sign * face.edge[k].At(x, y);
    if (at[0] + most_[0] < 0 || at[1] + most_[1] < 0 || at[2] + most_[2] < 0) return;
    for (int s = 0; s < count_; ++s) {
      const std::array<double, 3> areas = {at[0] + steps_[0][s], at[1] + steps_[1][s],
                                           at[2] + steps_[2][s]};
      if (areas[0] < 0 || areas[1] < 0 || areas[2] < 0) continue;
      const double inverse_depth = face.InverseDepth(areas);
      if (!(inverse_depth > inverse_depth_[first + s])) continue;  // nor where there is no area
      inverse_depth_[first + s] = inverse_depth;
      face_[first + s] = id;
    }
  }

  const ScanConversion& scan_;
  const PixelBox& box_;
  const std::vector<int>& places_;
  int width_, count_;
  std::vector<int> face_;              ///< by sample: the nearest so far
  std::vector<double> inverse_depth_;  ///< by sample: of that face
  std::array<std::vector<double>, 3> steps_;
  std::array<double, 3> most_;
};

void ScanConversion::Fill(const PixelBox& box, const std::vector<int>& places,
                          std::vector<RayScene::Hit>& hits) const {
  Filling filling(*this, box, places);
  if (!box.empty())
    for (int band = box.y0 / kBand; band <= (box.y1 - 1) / kBand; ++band)
      for (const int face : bands_[band])
        filling.Add(face, std::max(box.y0, band * kBand), std::min(box.y1, (band + 1) * kBand));
  filling.Finish(hits);
}

}  // namespace keypose
