#include "reconstruct/numerics/simplex_search.h"

#include <algorithm>
#include <vector>

namespace keypose::reconstruct {
namespace {

struct Vertex {
  Eigen::VectorXd x;
  double cost;
};

bool Better(const Vertex& a, const Vertex& b) { return a.cost < b.cost; }

}  // namespace

Eigen::VectorXd MinimizeSimplex(const std::function<double(const Eigen::VectorXd&)>& cost,
                                const Eigen::VectorXd& start, const Eigen::VectorXd& step,
                                int max_evaluations) {
  int evaluations = 0;
  const auto at = [&](const Eigen::VectorXd& x) {
    ++evaluations;
    return Vertex{x, cost(x)};
  };
  std::vector<Vertex> simplex{at(start)};
  for (Eigen::Index k = 0; k < start.size(); ++k) {
    Eigen::VectorXd x = start;
    x(k) += step(k);
    simplex.push_back(at(x));
  }
  std::stable_sort(simplex.begin(), simplex.end(), Better);
  while (evaluations < max_evaluations) {
    Eigen::VectorXd middle = Eigen::VectorXd::Zero(start.size());
    for (std::size_t i = 0; i + 1 < simplex.size(); ++i)
      middle += simplex[i].x / static_cast<double>(simplex.size() - 1);
    const Eigen::VectorXd away = middle - simplex.back().x;
    Vertex next = at(middle + away);
    if (Better(next, simplex.front())) {
      if (Vertex farther = at(middle + 2 * away); Better(farther, next)) next = std::move(farther);
    } else if (!Better(next, simplex[simplex.size() - 2])) {
      Vertex nearer = at(middle + (Better(next, simplex.back()) ? 0.5 : -0.5) * away);
      if (Better(nearer, next)) next = std::move(nearer);
    }
    if (Better(next, simplex.back())) {
      simplex.back() = std::move(next);
    } else {
      for (std::size_t i = 1; i < simplex.size(); ++i)
        simplex[i] = at((simplex[i].x + simplex[0].x) / 2);
    }
    std::stable_sort(simplex.begin(), simplex.end(), Better);
    if (((simplex.back().x - simplex.front().x).array().abs() <= 1e-7 * step.array().abs()).all())
      break;
  }
  return simplex.front().x;
}

}  // namespace keypose::reconstruct
