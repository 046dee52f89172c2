#include "reconstruct/surroundings/figure_motion.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/size_of.h"

namespace keypose::reconstruct {
namespace {

using Match = std::pair<std::uint32_t, std::uint32_t>;
using Matches = std::vector<Match>;

/// Up to this many times the limit of what stays in place, as many matches are the figure's own
/// near the table's axis.
constexpr double kHardly = 3;
/// Share of both motions' matches that one matrix has to fit for them to be one motion: a plane
/// and what stands on it are sometimes found one after the other.
constexpr double kOneMotion = 0.7;

constexpr int kSpreading = 2;  // rounds

struct PairData {
  const Features& first;
  const Features& second;
  const Eigen::VectorXf& likely_first;
  const Eigen::VectorXf& likely_second;
};

double Moved(const PairData& pair, const Match& match) {
  return static_cast<double>(
      (pair.first.positions.row(match.first) - pair.second.positions.row(match.second)).norm());
}

/// Matches that stay in place, if they are so many that something stands still before the camera.
Matches InPlace(const PairData& pair, const Matches& matches, double limit_px) {
  constexpr std::size_t kFewest = 8;
  Matches still;
  std::size_t hardly = 0;
  for (const Match& match : matches) {
    const double moved = Moved(pair, match);
    if (moved < limit_px)
      still.push_back(match);
    else
      hardly += moved < kHardly * limit_px;
  }
  if (still.size() < kFewest || still.size() <= hardly) still.clear();
  return still;
}

/// Sorted matches without others that are sorted too.
Matches Without(const Matches& all, const Matches& some) {
  Matches rest;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(), std::back_inserter(rest));
  return rest;
}

Matches Rigid(const PairData& pair, const Matches& matches, const VerificationOptions& options) {
  const auto verified = VerifyPair(pair.first, pair.second, {0, 1, matches}, options);
  if (!verified) return {};
  Matches inliers = verified->inliers.features;
  std::sort(inliers.begin(), inliers.end());
  return inliers;
}

bool AreOne(const PairData& pair, const Matches& a, const Matches& b,
            const VerificationOptions& options) {
  Matches both;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  const Matches fit = Rigid(pair, both, options);
  const auto share = [&](const Matches& of) {
    Matches in;
    std::set_intersection(of.begin(), of.end(), fit.begin(), fit.end(), std::back_inserter(in));
    return static_cast<double>(in.size()) / static_cast<double>(of.size());
  };
  return share(a) >= kOneMotion && share(b) >= kOneMotion;
}

/// The rigid motions of a pair, at most one that stays in place and two that do not.
std::vector<Matches> MotionsOf(const PairData& pair, Matches matches, double limit_px,
                               const FigureMotionOptions& options) {
  std::sort(matches.begin(), matches.end());
  std::vector<Matches> motions;
  Matches still = InPlace(pair, matches, limit_px);
  Matches rest = Without(matches, still);
  if (!still.empty()) motions.push_back(std::move(still));
  Matches first = Rigid(pair, rest, options.verification);
  if (first.empty()) return motions;
  rest = Without(rest, first);
  const Matches second = Rigid(pair, rest, options.verification);
  const auto enough = std::max(static_cast<double>(options.fewest),
                               options.of_rest * static_cast<double>(rest.size()));
  const bool is_second = static_cast<double>(second.size()) >= enough;
  if (is_second && AreOne(pair, first, second, options.verification)) {
    Matches both;
    std::set_union(first.begin(), first.end(), second.begin(), second.end(),
                   std::back_inserter(both));
    motions.push_back(std::move(both));
    return motions;
  }
  motions.push_back(std::move(first));
  if (is_second) motions.push_back(second);
  return motions;
}

/// How likely the matches of a motion are on the figure, in the mean: a wall and a table have many
/// more matches than the figure, but all around it.
double LikelyFigure(const PairData& pair, const Matches& motion) {
  double sum = 0;
  for (const auto& [i, j] : motion) sum += std::min(pair.likely_first(i), pair.likely_second(j));
  return sum / static_cast<double>(motion.size());
}

/// The motions of one pair, and which of them the figure follows.
struct Decision {
  std::vector<Matches> motions;
  int figure = -1;  ///< index of the figure's motion; -1 where that is not clear
};

Decision Decide(const PairData& pair, std::vector<Matches> motions, double clearly) {
  Decision decision{std::move(motions)};
  std::vector<std::pair<double, int>> likely;
  for (int m = 0; m < SizeOf(decision.motions); ++m)
    likely.emplace_back(LikelyFigure(pair, decision.motions[m]), m);
  if (likely.size() < 2) return decision;
  std::stable_sort(likely.begin(), likely.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  if (likely[0].first > clearly * likely[1].first) decision.figure = likely[0].second;
  return decision;
}

/// Counts for each feature the pairs in which it moves as the figure, and those in which it moves
/// otherwise.
class Votes {
 public:
  explicit Votes(const std::vector<Features>& features) {
    for (const Features& f : features)
      balance_.emplace_back(static_cast<std::size_t>(f.count()), 0);
  }
  void Add(const PairMatches& pair, const Decision& decision) {
    for (int m = 0; m < SizeOf(decision.motions); ++m)
      for (const auto& [i, j] : decision.motions[m]) {
        const int vote = m == decision.figure ? 1 : -1;
        balance_[pair.first][i] += vote;
        balance_[pair.second][j] += vote;
      }
  }
  /// Features without a vote follow those that they are matched with: where a table turns before a
  /// level camera, one matrix fits wall and figure, and such pairs decide nothing.
  void Spread(const std::vector<PairMatches>& matches) {
    std::vector<std::vector<int>> heard = balance_;
    for (const PairMatches& pair : matches)
      for (const auto& [i, j] : pair.features) {
        heard[pair.first][i] += Sign(balance_[pair.second][j]);
        heard[pair.second][j] += Sign(balance_[pair.first][i]);
      }
    for (std::size_t image = 0; image < balance_.size(); ++image)
      for (std::size_t f = 0; f < balance_[image].size(); ++f)
        if (balance_[image][f] == 0) balance_[image][f] = heard[image][f];
  }
  const std::vector<std::vector<int>>& balance() const { return balance_; }

 private:
  static int Sign(int x) { return (x > 0) - (x < 0); }
  std::vector<std::vector<int>> balance_;
};

}  // namespace

FigureMotion FollowFigure(const std::vector<Features>& features,
                          const std::vector<PairMatches>& matches,
                          const std::vector<Eigen::VectorXf>& likely, int longer_side_px,
                          const FigureMotionOptions& options, Progress* progress) {
  const double limit_px = std::max(1.0, options.in_place * longer_side_px);
  std::vector<Decision> decisions(matches.size());
  ParallelFor(std::ssize(matches), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const PairMatches& pair = matches[k];
    const PairData data{features[pair.first], features[pair.second], likely[pair.first],
                        likely[pair.second]};
    decisions[k] = Decide(data, MotionsOf(data, pair.features, limit_px, options), options.clearly);
  });
  FigureMotion result;
  Votes votes(features);
  for (std::size_t k = 0; k < matches.size(); ++k) {
    result.pairs_in_two += decisions[k].motions.size() > 1;
    if (decisions[k].figure < 0) continue;
    ++result.pairs_decided;
    votes.Add(matches[k], decisions[k]);
  }
  for (int round = 0; round < kSpreading; ++round) votes.Spread(matches);
  const bool in_two = result.pairs_decided >= options.fewest_pairs;
  for (const std::vector<int>& balance : votes.balance()) {
    std::vector<char> left(balance.size(), 0);
    for (std::size_t f = 0; in_two && f < balance.size(); ++f) {
      left[f] = balance[f] < 0;
      result.features_left += left[f];
    }
    result.left_behind.push_back(std::move(left));
  }
  return result;
}

}  // namespace keypose::reconstruct
