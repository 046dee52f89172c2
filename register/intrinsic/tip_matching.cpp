#include "register/intrinsic/tip_matching.h"

#include <algorithm>
#include <cmath>

#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

// Chosen on the seven registration pairs (docs/results/landmarks.md); sensitivity:
// docs/results/sensitivity.md.
struct TipMatchingTuning {
  // cost: reward for each pair of assigned tips, so that leaving tips out does not pay
  KEYPOSE_TUNED(double, kReward, 0.45);
  KEYPOSE_TUNED(double, kToleratedRatio, 0.5);  // relative change of distance that costs 1
  KEYPOSE_TUNED(double, kUnlikeWeight, 1.0);    // cost of a pair with the least alike descriptors
};

constexpr long kMostSteps = 2'000'000;

class TipSearch {
 public:
  TipSearch(const TipProblem& problem, int keep)
      : p_(problem),
        keep_(static_cast<std::size_t>(keep)),
        sources_(static_cast<int>(problem.source_distances.rows())),
        targets_(static_cast<int>(problem.target_distances.rows())),
        target_of_(static_cast<std::size_t>(sources_), -1),
        used_(static_cast<std::size_t>(targets_), 0) {}

  std::vector<TipAssignment> Run() {
    Descend(0, 0, 0);
    std::sort(best_.begin(), best_.end(), Better);
    return best_;
  }

 private:
  using Tuning = TipMatchingTuning;
  static bool Better(const TipAssignment& a, const TipAssignment& b) {
    return a.score != b.score ? a.score < b.score : a.target_of > b.target_of;
  }

  double PairCost(int a, int b, int ta, int tb) const {
    const double d1 = p_.source_distances(a, b), d2 = p_.target_distances(ta, tb);
    const double ratio = std::abs(d1 - d2) / (0.5 * (d1 + d2) + 0.05);
    return std::min(1.0, ratio / Tuning::kToleratedRatio) - Tuning::kReward;
  }

  /// What assigning source tip s to t adds to the score.
  double Added(int s, int t) const {
    double added = Tuning::kUnlikeWeight * p_.unlike(s, t);
    for (int a = 0; a < s; ++a)
      if (target_of_[a] >= 0) added += PairCost(a, s, target_of_[a], t);
    return added;
  }

  void Descend(int s, int assigned, double score) {
    if (s == sources_) return Keep(score);
    const int left = sources_ - s;
    const double most_gain = Tuning::kReward * (assigned * left + 0.5 * left * (left - 1));
    if (best_.size() == keep_ && score - most_gain >= best_.front().score) return;
    if (++steps_ > kMostSteps) return;
    if (s < p_.known) return Assign(s, s, assigned, score);
    std::vector<std::pair<double, int>> choices;
    for (int t = p_.known; t < targets_; ++t)
      if (!used_[t]) choices.emplace_back(Added(s, t), t);
    std::sort(choices.begin(), choices.end());  // best first, so that the bound prunes early
    for (const auto& [added, t] : choices) Assign(s, t, assigned, score);
    Descend(s + 1, assigned, score);
  }

  void Assign(int s, int t, int assigned, double score) {
    const double added = Added(s, t);
    target_of_[s] = t;
    used_[t] = 1;
    Descend(s + 1, assigned + 1, score + added);
    target_of_[s] = -1;
    used_[t] = 0;
  }

  void Keep(double score) {
    TipAssignment found{target_of_, score};
    const auto worse_first = [](const TipAssignment& a, const TipAssignment& b) {
      return Better(a, b);
    };
    if (best_.size() == keep_) {
      if (!Better(found, best_.front())) return;
      std::pop_heap(best_.begin(), best_.end(), worse_first);
      best_.pop_back();
    }
    best_.push_back(std::move(found));
    std::push_heap(best_.begin(), best_.end(), worse_first);  // the worst is in front
  }

  const TipProblem& p_;
  std::size_t keep_;
  int sources_, targets_;
  std::vector<int> target_of_;
  std::vector<char> used_;
  std::vector<TipAssignment> best_;
  long steps_ = 0;
};

}  // namespace

std::vector<TipAssignment> MatchTips(const TipProblem& problem, int keep) {
  return TipSearch(problem, std::max(1, keep)).Run();
}

}  // namespace keypose::registration
