#include "cleanup/support/support_cut.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Chosen on the shapes of support_plane_test; none of the collection of bad meshes, the plush dog
// and the skull may be taken for a support.
struct SupportTuning {
  KEYPOSE_TUNED(double, kFlat, 0.006);    // of the diagonal: half the thickness of a flat sheet
  KEYPOSE_TUNED(double, kLowest, 0.35);   // of the height: sheets above this belong to the figure
  KEYPOSE_TUNED(double, kDeepest, 0.12);  // of the diagonal: largest thickness of a support
  // of the diagonal: height of the figure's cross-section above the sheet
  KEYPOSE_TUNED(double, kAbove, 0.015);
  KEYPOSE_TUNED(double, kTall, 0.1);  // of the diagonal: smallest height of the figure
  // of the diagonal: height of the cut above the sheet; also removes the part that Poisson
  // reconstruction rounds off
  KEYPOSE_TUNED(double, kCutMargin, 0.005);
  KEYPOSE_TUNED(double, kSpread, 1.5);  // area of the sheet over that of the cross-section
  // share of the sheet's area beyond the cross-section that must be covered
  KEYPOSE_TUNED(double, kCover, 0.5);
  KEYPOSE_TUNED(double, kLevel, 0.966);  // cosine of 15 degrees: the steepest faces of a sheet
  KEYPOSE_TUNED(double, kTilt, 0.978);   // cosine of 12 degrees: the steepest sheet
};
constexpr double kBin = 0.0025;  // of the diagonal
constexpr int kPeaks = 4;

double HullArea(std::vector<Vector2d> points) {
  if (points.size() < 3) return 0;
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull;
  const auto left = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 0;
  };
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = hull.size() + 1;
    for (const Vector2d& p : points) {
      while (hull.size() > start && !left(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d &a = hull[i], &b = hull[(i + 1) % hull.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

// The mesh with the face data that the search needs.
class Search {
 public:
  explicit Search(const Mesh& mesh);
  std::vector<double> Peaks() const;
  /// The plane of a sheet near a height. Nothing when there is none, or when it is too steep.
  std::optional<CutPlane> Fit(double height) const;
  bool IsStand(const CutPlane& sheet) const;
  double diagonal() const { return diagonal_; }

 private:
  bool OnSheet(int f, const CutPlane& sheet) const {
    return std::abs(normals_.row(f).dot(sheet.normal.transpose())) > SupportTuning::kLevel &&
           std::abs(centers_.row(f).dot(sheet.normal.transpose()) - sheet.offset) <
               SupportTuning::kFlat * diagonal_;
  }

  const Mesh& mesh_;
  const Eigen::VectorXd areas_;
  const PointsX3 normals_;
  PointsX3 centers_;
  double diagonal_, bottom_, height_;
};

Search::Search(const Mesh& mesh)
    : mesh_(mesh),
      areas_(FaceAreas(mesh.points, mesh.faces)),
      normals_(FaceNormals(mesh.points, mesh.faces)),
      centers_(mesh.face_count(), 3),
      diagonal_(BoundingDiagonal(mesh.points)),
      bottom_(mesh.points.col(2).minCoeff()),
      height_(mesh.points.col(2).maxCoeff() - bottom_) {
  for (int f = 0; f < mesh.face_count(); ++f)
    centers_.row(f) = (mesh.points.row(mesh.faces(f, 0)) + mesh.points.row(mesh.faces(f, 1)) +
                       mesh.points.row(mesh.faces(f, 2))) /
                      3;
}

// Heights where level faces have much area, the highest first: the upper side of a base is the
// relevant one.
std::vector<double> Search::Peaks() const {
  const double bin = kBin * diagonal_;
  const int count = static_cast<int>(SupportTuning::kLowest * height_ / bin) + 1;
  std::vector<double> level(count, 0), piled(count, 0);
  for (int f = 0; f < mesh_.face_count(); ++f) {
    const double at = (centers_(f, 2) - bottom_) / bin;
    if (std::abs(normals_(f, 2)) > SupportTuning::kLevel && at < count)
      level[static_cast<int>(at)] += areas_[f];
  }
  for (int i = 0; i < count; ++i)
    for (int j = std::max(0, i - 2); j <= std::min(count - 1, i + 2); ++j) piled[i] += level[j];
  std::vector<int> order(count), peaks;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return piled[a] > piled[b]; });
  for (const int i : order) {
    const bool apart =
        std::all_of(peaks.begin(), peaks.end(), [&](int p) { return std::abs(p - i) > 3; });
    if (apart && piled[i] > 0 && SizeOf(peaks) < kPeaks) peaks.push_back(i);
  }
  std::sort(peaks.rbegin(), peaks.rend());
  std::vector<double> heights;
  for (const int i : peaks) heights.push_back(bottom_ + (i + 0.5) * bin);
  return heights;
}

std::optional<CutPlane> Search::Fit(double height) const {
  CutPlane sheet{Vector3d::UnitZ(), height};
  for (int round = 0; round < 4; ++round) {
    double weight = 0;
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int pass = 0; pass < 2; ++pass) {
      for (int f = 0; f < mesh_.face_count(); ++f) {
        if (!OnSheet(f, sheet)) continue;
        if (pass == 0) {
          weight += areas_[f];
          mean += areas_[f] * centers_.row(f);
        } else {
          const Vector3d d = (centers_.row(f) - mean).transpose();
          spread += areas_[f] * d * d.transpose();
        }
      }
      if (pass == 0) {
        if (!(weight > 0)) return std::nullopt;
        mean /= weight;
      }
    }
    Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
    if (normal.z() < 0) normal = -normal;
    if (normal.z() < SupportTuning::kTilt) return std::nullopt;
    sheet = {normal, normal.dot(mean.transpose())};
  }
  return sheet;
}

bool Search::IsStand(const CutPlane& sheet) const {
  using Tuning = SupportTuning;
  const Vector3d u = sheet.normal.cross(Vector3d::UnitX()).normalized(), v = sheet.normal.cross(u);
  const auto flat = [&](const Eigen::RowVector3d& x) {
    return Vector2d(x.dot(u.transpose()), x.dot(v.transpose()));
  };
  const Eigen::VectorXd heights = (mesh_.points * sheet.normal).array() - sheet.offset;
  const double above = Tuning::kAbove * diagonal_;
  if (heights.minCoeff() < -Tuning::kDeepest * diagonal_ ||
      heights.maxCoeff() < std::max(Tuning::kTall * diagonal_, -2 * heights.minCoeff()))
    return false;
  std::vector<Vector2d> on_sheet, section;
  double area = 0;
  for (int f = 0; f < mesh_.face_count(); ++f) {
    if (OnSheet(f, sheet)) {
      on_sheet.push_back(flat(centers_.row(f)));
      area += areas_[f];
    }
    for (int k = 0; k < 3; ++k) {
      const int a = mesh_.faces(f, k), b = mesh_.faces(f, (k + 1) % 3);
      if ((heights[a] < above) == (heights[b] < above)) continue;
      const double t = (above - heights[a]) / (heights[b] - heights[a]);
      section.push_back(flat((1 - t) * mesh_.points.row(a) + t * mesh_.points.row(b)));
    }
  }
  const double spread = HullArea(on_sheet), figure = HullArea(section);
  return figure > 0 && spread > Tuning::kSpread * figure &&
         area > Tuning::kCover * (spread - figure);
}

}  // namespace

std::optional<CutPlane> FindSupport(const Mesh& mesh) {
  const Search search(mesh);
  for (const double height : search.Peaks()) {
    std::optional<CutPlane> sheet = search.Fit(height);
    if (!sheet || !search.IsStand(*sheet)) continue;
    sheet->offset += SupportTuning::kCutMargin * search.diagonal();
    return sheet;
  }
  return std::nullopt;
}

Mesh ClippedAbove(const Mesh& mesh, const CutPlane& plane) {
  Eigen::VectorXd heights = (mesh.points * plane.normal).array() - plane.offset;
  const double snap = 1e-6 * BoundingDiagonal(mesh.points);
  std::vector<Vector3d> points;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    points.push_back(mesh.points.row(v).transpose());
    if (std::abs(heights[v]) > snap) continue;
    points.back() -= heights[v] * plane.normal;
    heights[v] = 0;
  }
  std::map<std::pair<int, int>, int> crossings;
  const auto crossing = [&](int a, int b) {
    const auto [it, is_new] = crossings.emplace(std::minmax(a, b), SizeOf(points));
    if (is_new) {
      const auto [low, high] = std::minmax(a, b);
      const double t = heights[low] / (heights[low] - heights[high]);
      points.push_back((1 - t) * points[low] + t * points[high]);
    }
    return it->second;
  };
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh.face_count(); ++f) {
    std::vector<int> kept;  // the part of the face that stays, as a polygon
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      if (heights[a] >= 0) kept.push_back(a);
      if (heights[a] * heights[b] < 0) kept.push_back(crossing(a, b));
    }
    const bool any_above = heights[mesh.faces(f, 0)] > 0 || heights[mesh.faces(f, 1)] > 0 ||
                           heights[mesh.faces(f, 2)] > 0;
    for (std::size_t i = 2; any_above && i < kept.size(); ++i)
      faces.emplace_back(kept[0], kept[i - 1], kept[i]);
  }
  Mesh out;
  out.points.resize(std::ssize(points), 3);
  for (std::size_t v = 0; v < points.size(); ++v) out.points.row(v) = points[v].transpose();
  out.faces.resize(std::ssize(faces), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) out.faces.row(f) = faces[f].transpose();
  return out;
}

}  // namespace keypose::cleanup
