#include "armature/live/joint_timing.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"

namespace keypose::armature {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Slopes at evenly spaced values, such that no piece leaves the range of its ends.
VectorXd MonotoneSlopes(const VectorXd& values) {
  const Index count = values.size();
  VectorXd slopes = VectorXd::Zero(count);
  // At the ends motion begins and stops: slope 0.
  for (Index i = 1; i + 1 < count; ++i) {
    const double before = values[i] - values[i - 1], after = values[i + 1] - values[i];
    if (before * after > 0) slopes[i] = 2 * before * after / (before + after);
  }
  return slopes;
}

double CubicAt(double a, double b, double slope_a, double slope_b, double t) {
  const double s = t * t, u = s * t;
  return (2 * u - 3 * s + 1) * a + (u - 2 * s + t) * slope_a + (3 * s - 2 * u) * b +
         (u - s) * slope_b;
}

/// From the first of a row of values that a stop does not cut to behind the last.
VectorXd SmoothedPart(const VectorXd& values, double sigma) {
  const Index reach = static_cast<Index>(std::ceil(3 * sigma));
  VectorXd smooth(values.size());
  for (Index i = 0; i < values.size(); ++i) {
    // As far to one side as to the other, so that ends stay where they are.
    const Index width = std::min({reach, i, values.size() - 1 - i});
    double sum = 0, weights = 0;
    for (Index k = -width; k <= width; ++k) {
      const double weight = std::exp(-0.5 * static_cast<double>(k * k) / (sigma * sigma));
      sum += weight * values[i + k];
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  return smooth;
}

}  // namespace

Between BetweenNamed(const std::string& name) {
  if (name == "hold") return Between::kHold;
  if (name == "linear") return Between::kLinear;
  if (name == "smooth") return Between::kSmooth;
  throw UsageError("between recorded frames it can hold, go linear or smooth, not '" + name + "'");
}

MatrixXd FilmValues(const MatrixXd& recorded, int step, Between between) {
  const Index count = recorded.rows();
  if (between == Between::kHold) {
    MatrixXd film(count * step, recorded.cols());
    for (Index f = 0; f < film.rows(); ++f) film.row(f) = recorded.row(f / step);
    return film;
  }
  MatrixXd film((count - 1) * step + 1, recorded.cols());
  for (Index j = 0; j < recorded.cols(); ++j) {
    const VectorXd values = recorded.col(j), slopes = MonotoneSlopes(values);
    for (Index f = 0; f < film.rows(); ++f) {
      const Index a = f / step, b = std::min(a + 1, count - 1);
      const double t = static_cast<double>(f % step) / step;
      if (t == 0)
        film(f, j) = values[a];
      else if (between == Between::kLinear)
        film(f, j) = (1 - t) * values[a] + t * values[b];
      else
        film(f, j) = CubicAt(values[a], values[b], slopes[a], slopes[b], t);
    }
  }
  return film;
}

std::vector<PoseRun> PoseRuns(const MatrixXd& recorded) {
  std::vector<PoseRun> runs;
  for (int f = 0; f < recorded.rows(); ++f) {
    if (f > 0 && recorded.row(f) == recorded.row(f - 1))
      ++runs.back().count;
    else
      runs.push_back({f, 1});
  }
  return runs;
}

MatrixXd Smoothed(const MatrixXd& recorded, double sigma) {
  MatrixXd smooth = recorded;
  for (Index j = 0; j < recorded.cols(); ++j) {
    Index begin = 0;
    for (Index f = 1; f <= recorded.rows(); ++f) {
      const bool stop = f == recorded.rows() || recorded(f, j) == recorded(f - 1, j);
      if (!stop) continue;
      smooth.col(j).segment(begin, f - begin) =
          SmoothedPart(recorded.col(j).segment(begin, f - begin), sigma);
      begin = f;
    }
  }
  return smooth;
}

}  // namespace keypose::armature
