#include "reconstruct/refinement/displacement_solve.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose::reconstruct {
namespace {

constexpr int kSolveGrain = 2048;
constexpr int kMaxRounds = 120;
constexpr double kRelativeResidual = 1e-3;  // of the initial residual

constexpr int kShapeRounds = 8;  // rounds of neighbours over which the surface's shape is averaged

using Values = std::vector<float>;

double Dot(const Values& a, const Values& b) {
  const std::int64_t count = std::ssize(a);
  std::vector<double> sums((count + kSolveGrain - 1) / kSolveGrain, 0.0);
  ParallelBlocks(count, kSolveGrain, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t i = begin; i < end; ++i) sum += static_cast<double>(a[i]) * b[i];
    sums[begin / kSolveGrain] = sum;
  });
  double total = 0;
  for (const double sum : sums) total += sum;
  return total;
}

// The quadratic form of the energy, applied without a matrix. It assumes parallel normals of
// neighbours: with their true cosines, the surface of least bending would shrink to nothing.
class Form {
 public:
  Form(const PointsX3& normals, const Neighbors& neighbors, const DisplacementEnergy& energy)
      : neighbors_(neighbors), energy_(energy), bend_(neighbors.vertex_count()) {
    const double spacing = neighbors.mean_edge / energy.unit;
    bending_ = static_cast<float>(energy.bending / std::pow(spacing, 4));
    membrane_ = static_cast<float>(energy.membrane);
    if (energy.slope_normals.rows() > 0) MakeSlopes(normals);
  }

  // Half the negative gradient of the energy at zero displacement.
  void RightSide(const PointsX3& points, const PointsX3& normals, Values* out) {
    ForBlocks([&](int v) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e)
        mean +=
            neighbors_.weight[e] * (points.row(neighbors_.vertex[e]) - points.row(v)).transpose();
      bend_[v] =
          static_cast<float>(-mean.dot(normals.row(v)) * neighbors_.inverse_sum[v] / energy_.unit);
    });
    // Bending at a large scale is the surface's shape, and is kept.
    Values shape = bend_;
    Diffuse(neighbors_, 1, kShapeRounds, std::vector<char>(bend_.size(), 1), &shape);
    ForBlocks([&](int v) { bend_[v] -= shape[v]; });
    ForBlocks([&](int v) {
      (*out)[v] = energy_.weight[v] * energy_.target[v] + bending_ * BendBack(v);
      if (slopes_.empty()) return;
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e) {
        const int u = neighbors_.vertex[e];
        const Eigen::Vector3d m =
            (energy_.slope_normals.row(u) + energy_.slope_normals.row(v)).normalized();
        const double rise = m.dot(points.row(u) - points.row(v)) / energy_.unit;
        (*out)[v] += static_cast<float>(slopes_[e].weight * slopes_[e].own * rise);
      }
    });
  }

  void Apply(const Values& d, Values* out) {
    ForBlocks([&](int v) {
      float mean = 0;
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e)
        mean += neighbors_.weight[e] * d[neighbors_.vertex[e]];
      bend_[v] = mean * neighbors_.inverse_sum[v] - (neighbors_.inverse_sum[v] > 0 ? d[v] : 0);
    });
    ForBlocks([&](int v) {
      float pull = 0;
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e)
        pull += d[v] - d[neighbors_.vertex[e]];
      (*out)[v] = (energy_.weight[v] + static_cast<float>(energy_.anchor)) * d[v] +
                  membrane_ * pull + bending_ * BendBack(v);
      if (slopes_.empty()) return;
      float slope = 0;
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e) {
        const Slope& s = slopes_[e];
        slope += s.weight * s.own * (s.own * d[v] - s.other * d[neighbors_.vertex[e]]);
      }
      (*out)[v] += slope;
    });
  }

  void Diagonal(Values* out) const {
    ForBlocks([&](int v) {
      float bend = neighbors_.inverse_sum[v] > 0 ? 1 : 0;
      const int first = neighbors_.begin[v], last = neighbors_.begin[v + 1];
      for (int e = first; e < last; ++e) {
        const float share = neighbors_.weight[e] * neighbors_.inverse_sum[neighbors_.vertex[e]];
        bend += share * share;
      }
      (*out)[v] = energy_.weight[v] + static_cast<float>(energy_.anchor) +
                  membrane_ * static_cast<float>(last - first) + bending_ * bend;
      if (slopes_.empty()) return;
      for (int e = first; e < last; ++e)
        (*out)[v] += slopes_[e].weight * slopes_[e].own * slopes_[e].own;
    });
  }

  template <class Body>
  void ForBlocks(const Body& body) const {
    ParallelBlocks(neighbors_.vertex_count(), kSolveGrain,
                   [&](std::int64_t begin, std::int64_t end) {
                     for (std::int64_t v = begin; v < end; ++v) body(static_cast<int>(v));
                   });
  }

 private:
  // The transpose of the umbrella operator, applied to bend_ and gathered per vertex.
  float BendBack(int v) const {
    float sum = neighbors_.inverse_sum[v] > 0 ? -bend_[v] : 0;
    for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e) {
      const int u = neighbors_.vertex[e];
      sum += neighbors_.weight[e] * neighbors_.inverse_sum[u] * bend_[u];
    }
    return sum;
  }

  // The height difference along an edge from v to u changes by other * d_u - own * d_v.
  struct Slope {
    float weight = 0, own = 0, other = 0;
  };
  void MakeSlopes(const PointsX3& normals) {
    slopes_.resize(neighbors_.vertex.size());
    ForBlocks([&](int v) {
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e) {
        const int u = neighbors_.vertex[e];
        const Eigen::Vector3d m =
            (energy_.slope_normals.row(u) + energy_.slope_normals.row(v)).normalized();
        slopes_[e] = {0.5f * (energy_.slope_weight[u] + energy_.slope_weight[v]),
                      static_cast<float>(m.dot(normals.row(v))),
                      static_cast<float>(m.dot(normals.row(u)))};
      }
    });
  }

  const Neighbors& neighbors_;
  const DisplacementEnergy& energy_;
  std::vector<Slope> slopes_;
  float bending_ = 0, membrane_ = 0;
  Values bend_;
};

}  // namespace

Neighbors MakeNeighbors(const PointsX3& points, const FacesX3& faces) {
  const std::vector<std::pair<int, int>> edges = UndirectedEdges(faces);
  Neighbors out;
  out.begin.assign(points.rows() + 1, 0);
  for (const auto& [i, j] : edges) {
    ++out.begin[i + 1];
    ++out.begin[j + 1];
    out.mean_edge += (points.row(i) - points.row(j)).norm() / static_cast<double>(edges.size());
  }
  for (std::size_t v = 1; v < out.begin.size(); ++v) out.begin[v] += out.begin[v - 1];
  out.vertex.resize(2 * edges.size());
  out.weight.resize(2 * edges.size());
  std::vector<int> next(out.begin.begin(), out.begin.end() - 1);
  for (const auto& [i, j] : edges) {
    const double length = (points.row(i) - points.row(j)).norm();
    const float weight =
        static_cast<float>(std::clamp(out.mean_edge / std::max(length, 1e-30), 0.25, 4.0));
    out.vertex[next[i]] = j;
    out.weight[next[i]++] = weight;
    out.vertex[next[j]] = i;
    out.weight[next[j]++] = weight;
  }
  out.inverse_sum.assign(points.rows(), 0.0f);
  for (int v = 0; v < out.vertex_count(); ++v) {
    float sum = 0;
    for (int e = out.begin[v]; e < out.begin[v + 1]; ++e) sum += out.weight[e];
    if (sum > 0) out.inverse_sum[v] = 1 / sum;
  }
  return out;
}

int SolveDisplacement(const PointsX3& points, const PointsX3& normals, const Neighbors& neighbors,
                      const DisplacementEnergy& energy, Values* start) {
  Form form(normals, neighbors, energy);
  const std::size_t count = start->size();
  Values &x = *start, r(count), z(count), p(count), q(count), diagonal(count);
  form.Diagonal(&diagonal);
  form.RightSide(points, normals, &r);
  const double size = std::sqrt(Dot(r, r));
  form.Apply(x, &q);
  form.ForBlocks([&](int v) {
    r[v] -= q[v];
    z[v] = r[v] / diagonal[v];
    p[v] = z[v];
  });
  double rz = Dot(r, z);
  int round = 0;
  for (; round < kMaxRounds && std::sqrt(Dot(r, r)) > kRelativeResidual * size && rz > 0; ++round) {
    form.Apply(p, &q);
    const float alpha = static_cast<float>(rz / Dot(p, q));
    form.ForBlocks([&](int v) {
      x[v] += alpha * p[v];
      r[v] -= alpha * q[v];
      z[v] = r[v] / diagonal[v];
    });
    const double next = Dot(r, z);
    const float beta = static_cast<float>(next / rz);
    form.ForBlocks([&](int v) { p[v] = z[v] + beta * p[v]; });
    rz = next;
  }
  return round;
}

void Diffuse(const Neighbors& neighbors, int columns, int rounds, const std::vector<char>& use,
             Values* values) {
  Values from;
  std::vector<char> known = use, next = use;
  for (int round = 0; round < rounds; ++round) {
    from = *values;
    ParallelBlocks(
        neighbors.vertex_count(), kSolveGrain, [&](std::int64_t begin, std::int64_t end) {
          Values mean(columns);
          for (std::int64_t v = begin; v < end; ++v) {
            float sum = 0;
            std::fill(mean.begin(), mean.end(), 0.0f);
            for (int e = neighbors.begin[v]; e < neighbors.begin[v + 1]; ++e) {
              const int u = neighbors.vertex[e];
              if (!known[u]) continue;
              sum += neighbors.weight[e];
              for (int c = 0; c < columns; ++c)
                mean[c] += neighbors.weight[e] * from[static_cast<std::size_t>(u) * columns + c];
            }
            if (sum <= 0) continue;
            const float own = known[v] ? 0.5f : 0.0f;
            for (int c = 0; c < columns; ++c) {
              float& value = (*values)[v * columns + c];
              value = own * value + (1 - own) * mean[c] / sum;
            }
            next[v] = 1;
          }
        });
    known = next;
  }
}

}  // namespace keypose::reconstruct
