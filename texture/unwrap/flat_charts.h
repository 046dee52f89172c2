// Charts of a closed surface that are cut until each is nearly flat, then joined while they stay
// so.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/values/progress.h"
#include "texture/charts/hidden_seams.h"

namespace keypose::texture {

struct FlatChart {
  Chart chart;
  UvsX2 uvs;
};

/// Call Cut first, then the other steps in any order. The charts always cover every face once.
class ChartAtlas {
 public:
  /// @param seam_costs  cost of a seam along edge k of each face, F x 3; all > 0
  ChartAtlas(const Surface& surface, const PointsX3& seam_costs, double max_distortion,
             Progress* progress)
      : surface_(surface),
        costs_(seam_costs),
        lengths_(SeamCosts(surface, Eigen::VectorXd::Ones(surface.points.rows()))),
        max_distortion_(max_distortion),
        progress_(progress) {}

  /// Makes many small charts, with borders where seams have low cost.
  /// @throws InputError  a face without area
  void Cut();
  /// Merges neighbours, costly borders first, while the joint chart stays flat enough.
  /// @param largest_share  of the whole area, for one chart
  void Join(double largest_share);
  /// Moves each border to the cheapest position near it with which both charts stay flat enough.
  void Hide();
  /// Relaxes each chart to convergence.
  void Refine();
  const std::vector<FlatChart>& charts() const { return charts_; }

 private:
  std::optional<FlatChart> TryFlat(std::vector<int> faces, int rounds, double slack = 1) const;
  void Settle(std::vector<std::vector<int>> work);
  std::vector<int> Labels() const;
  std::map<std::pair<int, int>, double> Shared(const std::vector<int>& label,
                                               const PointsX3& of_edges) const;
  double RimCost(const FlatChart& chart, const std::vector<int>& label) const;
  bool WorthJoining(const FlatChart& a, const FlatChart& b) const;
  bool JoinRound(std::set<std::pair<int, int>>& failed);

  const Surface& surface_;
  const PointsX3& costs_;
  PointsX3 lengths_;  // of edges, in the layout of costs_
  double max_distortion_, largest_share_ = 1;
  Progress* progress_;
  std::vector<FlatChart> charts_;
};

}  // namespace keypose::texture
