// A triangle divided into equal small ones; values at the nodes are interpolated linearly.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace keypose::texture {

/// n parts per side, n >= 1; (n + 1)(n + 2) / 2 nodes.
class FaceLattice {
 public:
  explicit FaceLattice(int parts) : parts_(parts) {}
  static int CountOf(int parts) { return (parts + 1) * (parts + 2) / 2; }

  /// Barycentric weights of each node, in the order of Between's indices.
  template <class Visit>
  void ForNodes(const Visit& visit) const {
    const float unit = 1 / static_cast<float>(parts_);
    for (int i = 0; i <= parts_; ++i)
      for (int j = 0; i + j <= parts_; ++j)
        visit(Eigen::Vector3f(unit * static_cast<float>(parts_ - i - j),
                              unit * static_cast<float>(i), unit * static_cast<float>(j)));
  }

  /// The small triangle that contains a point of the face, and the point's weights in it. Points
  /// outside by rounding are moved to the outline.
  struct Corners {
    int node[3];
    float weight[3];
  };
  Corners Between(const Eigen::Vector3f& weights) const {
    const float n = static_cast<float>(parts_);
    const float x = std::clamp(n * weights[1], 0.0f, n), y = std::clamp(n * weights[2], 0.0f, n);
    const int i = std::min(static_cast<int>(x), parts_ - 1),
              j = std::min(static_cast<int>(y), parts_ - 1 - i);
    const float fx = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f),
                fy = std::clamp(y - static_cast<float>(j), 0.0f, 1.0f);
    if (fx + fy <= 1) return {{Node(i, j), Node(i + 1, j), Node(i, j + 1)}, {1 - fx - fy, fx, fy}};
    if (i + j == parts_ - 1)
      return {{Node(i, j), Node(i + 1, j), Node(i, j + 1)}, {0, fx / (fx + fy), fy / (fx + fy)}};
    return {{Node(i + 1, j + 1), Node(i, j + 1), Node(i + 1, j)}, {fx + fy - 1, 1 - fx, 1 - fy}};
  }

 private:
  int Node(int i, int j) const { return i * (parts_ + 1) - i * (i - 1) / 2 + j; }

  int parts_;
};

}  // namespace keypose::texture
