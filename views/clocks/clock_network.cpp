#include "views/clocks/clock_network.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/size_of.h"

namespace keypose {
namespace {

constexpr double kNoEvidence = 1e-9;  // weight of 0, so that films without links have an answer
constexpr double kStep_s = 1e-5;      // that clocks are rounded to: same pictures on all processors

/// x with x[b] - x[a] nearest to the differences, x[0] = 0.
Eigen::VectorXd FromDifferences(int films, const std::vector<ClockLink>& links,
                                const std::vector<double>& differences,
                                const std::vector<bool>& counts) {
  Eigen::MatrixXd normal = kNoEvidence * Eigen::MatrixXd::Identity(films, films);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(films);
  normal(0, 0) += 1e6;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (!counts[l]) continue;
    const int a = links[l].a, b = links[l].b;
    normal(a, a) += 1, normal(b, b) += 1, normal(a, b) -= 1, normal(b, a) -= 1;
    right(a) -= differences[l], right(b) += differences[l];
  }
  return normal.ldlt().solve(right);
}

bool Drifts(const ClockLink& link, double least_s) {
  return link.drift.measured && std::abs(link.drift.last_s - link.drift.first_s) > least_s;
}

void FindRates(const std::vector<ClockLink>& links, double least_drift_s,
               std::vector<FilmClock>* clocks) {
  if (std::none_of(links.begin(), links.end(),
                   [&](const ClockLink& link) { return Drifts(link, least_drift_s); }))
    return;
  std::vector<double> differences;
  std::vector<bool> counts;
  for (const ClockLink& link : links) {
    differences.push_back(-std::log1p(link.drift.per_second()));
    counts.push_back(link.drift.measured);
  }
  const Eigen::VectorXd logs = FromDifferences(SizeOf(*clocks), links, differences, counts);
  for (int f = 0; f < SizeOf(*clocks); ++f) (*clocks)[f].rate = std::exp(logs(f));
}

/// When what one link saw in both films was, by the clock of each.
std::pair<double, double> SameMoment(const ClockDrift& drift) {
  if (!drift.measured) return {drift.whole.middle_s, drift.whole.middle_s + drift.whole.seconds};
  const double at = 0.5 * (drift.first_at_s + drift.last_at_s);
  return {at, at + 0.5 * (drift.first_s + drift.last_s)};
}

}  // namespace

std::vector<bool> ConfirmedByThird(const std::vector<ClockLink>& links, double within_s) {
  std::map<std::pair<int, int>, int> at;
  for (int l = 0; l < SizeOf(links); ++l) at[{links[l].a, links[l].b}] = l;
  std::vector<bool> confirmed(links.size(), false);
  for (const auto& [first, i] : at)
    for (const auto& [second, j] : at) {
      const auto whole = at.find({first.first, second.second});
      if (first.second != second.first || whole == at.end()) continue;
      const auto seconds = [&](int l) { return links[l].drift.whole.seconds; };
      if (std::abs(seconds(i) + seconds(j) - seconds(whole->second)) > within_s) continue;
      confirmed[i] = confirmed[j] = confirmed[whole->second] = true;
    }
  return confirmed;
}

std::vector<int> LinkedGroups(int films, const std::vector<ClockLink>& links) {
  std::vector<int> group(static_cast<std::size_t>(films));
  for (int f = 0; f < films; ++f) group[f] = f;
  for (const ClockLink& link : links) {
    const int low = std::min(group[link.a], group[link.b]);
    const int high = std::max(group[link.a], group[link.b]);
    std::replace(group.begin(), group.end(), high, low);
  }
  int next = 0;
  for (int f = 0; f < films; ++f)
    if (group[f] >= next) {
      std::replace(group.begin(), group.end(), group[f], next);
      ++next;
    }
  return group;
}

ClockNetwork SolveClocks(int films, const std::vector<ClockLink>& links, double least_drift_s) {
  ClockNetwork network;
  network.clocks.resize(static_cast<std::size_t>(films));
  FindRates(links, least_drift_s, &network.clocks);
  std::vector<double> differences;
  for (const ClockLink& link : links) {
    const auto [at_a, at_b] = SameMoment(link.drift);
    differences.push_back(network.clocks[link.a].rate * at_a - network.clocks[link.b].rate * at_b);
  }
  const Eigen::VectorXd begins =
      FromDifferences(films, links, differences, std::vector<bool>(links.size(), true));
  for (std::size_t l = 0; l < links.size(); ++l) {
    const double off = std::abs(begins(links[l].b) - begins(links[l].a) - differences[l]);
    if (off <= network.worst_s && network.worst_link >= 0) continue;
    network.worst_s = off;
    network.worst_link = static_cast<int>(l);
  }
  for (int f = 0; f < films; ++f)
    network.clocks[f].begin_s = std::round((begins(f) - begins.minCoeff()) / kStep_s) * kStep_s;
  return network;
}

}  // namespace keypose
