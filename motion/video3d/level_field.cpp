#include "motion/video3d/level_field.h"

#include <cmath>

#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3f;

constexpr std::uint8_t kSureTexel = 230;  // of 255
constexpr float kOwnRatio = 0.1f;         // weight of a vertex's own ratio, in that of an edge
constexpr float kSameThing = 0.12f;       // larger differences of logarithms are not light
constexpr float kOverallWeight = 1e-4f;   // weight of the overall ratio
constexpr int kStepsAtFirst = 200, kNextSteps = 30;  // of conjugate gradients

Vector3f MedianRow(const LevelFactors& rows, const std::vector<int>& used) {
  Vector3f median = Vector3f::Zero();
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (const int v : used) values.push_back(rows(v, c));
    median[c] = UpperMedian(std::move(values));
  }
  return median;
}

}  // namespace

Vector3f Levelled(const Vector3f& linear, const Vector3f& log_factors) {
  return ((linear.array() + kLevelDark) * log_factors.array().exp() - kLevelDark)
      .max(0.0f)
      .min(1.0f)
      .matrix();
}

/// Per vertex: the logarithm of own over other, and its weight (0: not known).
struct LevelField::Ratios {
  LevelFactors logs;
  Eigen::VectorXf weight;
  Vector3f median = Vector3f::Zero();
};

LevelField::LevelField(int vertex_count, const FacesX3& faces, const SurfaceTexels& texels)
    : faces_(faces),
      texels_(texels),
      edges_(UndirectedEdges(faces)),
      degree_(Eigen::VectorXf::Zero(vertex_count)),
      factors_(LevelFactors::Zero(vertex_count, 3)) {
  for (const auto& [a, b] : edges_) {
    ++degree_[a];
    ++degree_[b];
  }
}

LevelField::Ratios LevelField::Measure(const TexelColors& own, const TexelColors& other) const {
  const Eigen::Index vertices = degree_.size();
  LevelFactors mine = LevelFactors::Zero(vertices, 3), theirs = mine;
  Ratios ratios{LevelFactors::Zero(vertices, 3), Eigen::VectorXf::Zero(vertices), {}};
  for (int i = 0; i < texels_.count(); ++i) {
    if (own.sure[i] < kSureTexel || other.sure[i] < kSureTexel) continue;
    const Vector3f w = texels_.weights[i].cwiseAbs2();
    const std::size_t at = 3 * static_cast<std::size_t>(i);
    for (int k = 0; k < 3; ++k) {
      const int v = faces_(texels_.face[i], k);
      for (int c = 0; c < 3; ++c) {
        mine(v, c) += w[k] * LinearOf(own.color[at + c]);
        theirs(v, c) += w[k] * LinearOf(other.color[at + c]);
      }
      ratios.weight[v] += w[k];
    }
  }
  std::vector<int> known;
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const float sum = ratios.weight[v];
    ratios.weight[v] = sum > 1e-3f ? 1 : 0;
    if (ratios.weight[v] == 0) continue;
    known.push_back(static_cast<int>(v));
    ratios.logs.row(v) =
        ((mine.row(v).array() / sum + kLevelDark) / (theirs.row(v).array() / sum + kLevelDark))
            .log();
  }
  ratios.median = MedianRow(ratios.logs, known);
  return ratios;
}

void LevelField::Smooth(const Ratios& ratios) {
  const Eigen::VectorXf hold = kOwnRatio * ratios.weight;
  const Eigen::VectorXf diagonal =
      degree_ + hold + Eigen::VectorXf::Constant(hold.size(), kOverallWeight);
  const auto times = [&](const LevelFactors& x) {
    LevelFactors y = x.array().colwise() * diagonal.array();
    for (const auto& [a, b] : edges_) {
      y.row(a) -= x.row(b);
      y.row(b) -= x.row(a);
    }
    return y;
  };
  LevelFactors right = ratios.logs.array().colwise() * hold.array();
  right.rowwise() += kOverallWeight * ratios.median.transpose();
  // Conjugate gradients on the three colours at once, preconditioned by the diagonal.
  LevelFactors residual = right - times(factors_);
  LevelFactors z = residual.array().colwise() / diagonal.array(), way = z;
  Eigen::RowVector3f old = residual.cwiseProduct(z).colwise().sum();
  const Eigen::RowVector3f enough =
      1e-8f * right.cwiseProduct(right).colwise().sum().array() + 1e-12f;
  for (int step = 0; step < (first_ ? kStepsAtFirst : kNextSteps); ++step) {
    if ((old.array() <= enough.array()).all()) break;
    const LevelFactors moved = times(way);
    const Eigen::RowVector3f curve = way.cwiseProduct(moved).colwise().sum();
    const Eigen::RowVector3f pace = (curve.array() > 0).select(old.array() / curve.array(), 0.0f);
    factors_ += (way.array().rowwise() * pace.array()).matrix();
    residual -= (moved.array().rowwise() * pace.array()).matrix();
    z = residual.array().colwise() / diagonal.array();
    const Eigen::RowVector3f next = residual.cwiseProduct(z).colwise().sum();
    const Eigen::RowVector3f keep = (old.array() > 0).select(next.array() / old.array(), 0.0f);
    way = z + (way.array().rowwise() * keep.array()).matrix();
    old = next;
  }
}

const LevelFactors& LevelField::Match(const TexelColors& own, const TexelColors& other) {
  Ratios ratios = Measure(own, other);
  if (first_) factors_.rowwise() = ratios.median.transpose();
  for (Eigen::Index v = 0; v < ratios.weight.size(); ++v)
    if (ratios.weight[v] > 0)
      ratios.weight[v] = 1 / (1 + (ratios.logs.row(v) - factors_.row(v)).squaredNorm() /
                                      (kSameThing * kSameThing));
  Smooth(ratios);
  first_ = false;
  return factors_;
}

}  // namespace keypose::motion
