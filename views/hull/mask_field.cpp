#include "views/hull/mask_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace keypose {
namespace {

constexpr float kFar = 1e4f;  // [px] where a column or a picture has nothing of the other kind

/// Distance of each pixel to the nearest of its column that is on the other side of the outline.
std::vector<float> DistanceInColumn(const std::vector<char>& inside, int width, int height) {
  std::vector<float> distance(inside.size());
  std::fill_n(distance.begin(), width, kFar);
  const auto sweep = [&](std::size_t to, std::size_t from) {
    const char *kind = inside.data() + to, *before = inside.data() + from;
    const float* nearest_before = distance.data() + from;
    float* nearest = distance.data() + to;
    for (int x = 0; x < width; ++x) {
      const float next = kind[x] != before[x] ? 1.0f : nearest_before[x] + 1;
      nearest[x] = std::min(nearest[x], next);
    }
  };
  const auto row = [&](int y) { return static_cast<std::size_t>(y) * width; };
  for (int y = 1; y < height; ++y) {
    std::fill_n(distance.begin() + static_cast<std::ptrdiff_t>(row(y)), width, kFar);
    sweep(row(y), row(y - 1));
  }
  for (int y = height - 2; y >= 0; --y) sweep(row(y), row(y + 1));
  return distance;
}

/// Squared distances along rows: lower envelopes of parabolas.
/// Source: Felzenszwalb & Huttenlocher, Theory of Computing 2012.
class RowEnvelope {
 public:
  explicit RowEnvelope(int width)
      : f_(width), boundary_(static_cast<std::size_t>(width) + 1), parabola_(width) {}

  /// What the pixels of a row have in their columns, squared; for [first, end).
  float& At(int x) { return f_[x]; }
  /// Calls set(x, squared distance) for [first, end).
  template <class Set>
  void Visit(int first, int end, Set&& set) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    int k = 0;
    parabola_[0] = first;
    boundary_[0] = -kInfinity;
    boundary_[1] = kInfinity;
    for (int q = first + 1; q < end; ++q) {
      float s = Crossing(parabola_[k], q);
      while (s <= boundary_[k] && k > 0) s = Crossing(parabola_[--k], q);
      parabola_[++k] = q;
      boundary_[k] = s;
      boundary_[k + 1] = kInfinity;
    }
    k = 0;
    for (int q = first; q < end; ++q) {
      while (boundary_[k + 1] < static_cast<float>(q)) ++k;
      const auto delta = static_cast<float>(q - parabola_[k]);
      set(q, delta * delta + f_[parabola_[k]]);
    }
  }

 private:
  float Crossing(int p, int q) const {
    const auto a = static_cast<float>(p), b = static_cast<float>(q);
    return ((f_[q] + b * b) - (f_[p] + a * a)) / (2.0f * (b - a));
  }

  std::vector<float> f_, boundary_;
  std::vector<int> parabola_;
};

/// Distance of each pixel to the nearest one on the other side of the outline.
std::vector<float> DistanceAcross(const std::vector<char>& inside, int width, int height) {
  std::vector<float> distance = DistanceInColumn(inside, width, height);
  RowEnvelope envelope(width);
  for (int y = 0; y < height; ++y) {
    const char* kind = inside.data() + static_cast<std::size_t>(y) * width;
    float* row = distance.data() + static_cast<std::size_t>(y) * width;
    // What is beyond the next pixel of the other kind is farther than that pixel.
    for (int first = 0, end = 0; first < width; first = end) {
      while (end < width && kind[end] == kind[first]) {
        const float d = std::min(row[end], kFar);
        envelope.At(end++) = d * d;
      }
      const int before = std::max(first - 1, 0), after = std::min(end + 1, width);
      if (first > 0) envelope.At(before) = 0;
      if (end < width) envelope.At(end) = 0;
      envelope.Visit(before, after, [&](int x, float squared) {
        if (x >= first && x < end) row[x] = std::sqrt(squared);
      });
    }
  }
  return distance;
}

// The crop has a margin around the mask wherever the photograph continues. So a mask that touches
// the crop's side touches the photograph's side.
std::array<bool, 4> MaskEdges(const GreyMask& grey) {
  std::array<bool, 4> edges{};
  for (int y = 0; y < grey.height; ++y) {
    edges[0] |= InMask(*grey.at(0, y));
    edges[1] |= InMask(*grey.at(grey.width - 1, y));
  }
  for (int x = 0; x < grey.width; ++x) {
    edges[2] |= InMask(*grey.at(x, 0));
    edges[3] |= InMask(*grey.at(x, grey.height - 1));
  }
  return edges;
}

}  // namespace

MaskField MakeMaskField(const PreparedView& view, int level) {
  const PreparedView::Level& source = view.levels[level];
  MaskField field;
  field.width = source.camera.width;
  field.height = source.camera.height;
  field.focal = source.camera.fx;
  field.edges = MaskEdges(view.levels[0].grey);
  Eigen::Matrix<double, 3, 4> motion;
  motion.leftCols<3>() = view.camera_from_world.rotation.toRotationMatrix();
  motion.col(3) = view.camera_from_world.translation;
  field.from_world = source.camera.K() * motion;
  std::vector<char> inside(source.grey.data.size());
  for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = InMask(source.grey.data[i]);
  field.distance = DistanceAcross(inside, field.width, field.height);
  for (std::size_t i = 0; i < inside.size(); ++i)
    field.distance[i] = inside[i] ? 0.5f - field.distance[i] : field.distance[i] - 0.5f;
  return field;
}

}  // namespace keypose
