#include "fit/bending/pick_constraints.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/values/size_of.h"

namespace keypose::fit {

PickConstraints::PickConstraints(BendPicks marks, const PointsX3& rest,
                                 const std::vector<int>& cells)
    : marks_(std::move(marks)), rest_(rest), cell_of_(cells) {
  refused_.assign(count(), 0);
  if (count() == 0) return;
  members_.resize(*std::max_element(cells.begin(), cells.end()) + 1);
  for (int v = 0; v < SizeOf(cells); ++v) members_[cells[v]].push_back(v);
}

const std::string& PickConstraints::NameOf(int mark) const {
  const int pixels = SizeOf(marks_.pixels);
  return mark < pixels ? marks_.pixels[mark].name : marks_.places[mark - pixels].name;
}

/// Shares a mark's pull among the vertices of its cell, whose arms reach to the mark.
void PickConstraints::Pull(const Constraint& of_mark, const SurfacePoint& point,
                           std::vector<Constraint>& constraints) const {
  int corner = 0;
  point.weights.maxCoeff(&corner);
  const Eigen::Vector3d place = PositionOf(point, rest_);
  const std::vector<int>& members = members_[cell_of_[point.vertices[corner]]];
  for (const int v : members)
    constraints.push_back({of_mark.view, v, place - rest_.row(v).transpose(),
                           of_mark.q / static_cast<double>(members.size()), of_mark.goal});
}

void PickConstraints::AddPixels(const FitView& view, const PointsX3& points, double weight,
                                double scale, std::vector<Constraint>& constraints) const {
  for (int i = 0; i < SizeOf(marks_.pixels); ++i) {
    const PixelPick& mark = marks_.pixels[i];
    if (mark.view != view.index || refused_[i]) continue;
    Pull(PullToPixel(view, 0, Eigen::Vector3d::Zero(), PositionOf(mark.point, points), mark.pixel,
                     weight, scale),
         mark.point, constraints);
  }
}

void PickConstraints::AddPlaces(const PointsX3& points, double weight, double scale,
                                std::vector<Constraint>& constraints) const {
  for (int i = 0; i < SizeOf(marks_.places); ++i) {
    const LandmarkGoal& mark = marks_.places[i];
    if (refused_[SizeOf(marks_.pixels) + i]) continue;
    const double off = (PositionOf(mark.source, points) - mark.target).norm();
    const Eigen::Matrix3d q = weight * RobustWeight(off, scale) * Eigen::Matrix3d::Identity();
    Pull({-1, 0, Eigen::Vector3d::Zero(), q, mark.target}, mark.source, constraints);
  }
}

std::vector<PickQuality> PickConstraints::Quality(const std::vector<FitView>& views,
                                                  const PointsX3& points) const {
  std::vector<PickQuality> quality;
  for (const PixelPick& mark : marks_.pixels) {
    const FitView& view = views[mark.view];
    const Eigen::Vector3d x = view.camera_from_world * PositionOf(mark.point, points);
    const double off_px = (view.camera.Project(x) - mark.pixel).norm();
    quality.push_back({false, off_px * x.z() / view.camera.fx, off_px});
  }
  for (const LandmarkGoal& mark : marks_.places)
    quality.push_back({false, (PositionOf(mark.source, points) - mark.target).norm(), 0});
  for (int i = 0; i < count(); ++i) quality[i].refused = refused_[i] != 0;
  return quality;
}

bool PickConstraints::Refuse(const std::vector<FitView>& views, const PointsX3& points,
                             double limit) {
  const std::vector<PickQuality> quality = Quality(views, points);
  std::map<std::string, int> worst;
  for (int i = 0; i < count(); ++i) {
    if (refused_[i] || quality[i].off <= limit) continue;
    const auto [at, added] = worst.emplace(NameOf(i), i);
    if (!added && quality[i].off > quality[at->second].off) at->second = i;
  }
  for (const auto& [name, mark] : worst) refused_[mark] = 1;
  return !worst.empty();
}

}  // namespace keypose::fit
