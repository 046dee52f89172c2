// Disjoint sets that can be joined, for connected components.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace keypose {

/// Disjoint sets of the numbers 0 .. count - 1. A set is identified by its lowest member, so the
/// result does not depend on the order of joining.
class UnionFind {
 public:
  explicit UnionFind(std::ptrdiff_t count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  /// The lowest member of i's set.
  int Find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// @return whether they were in different sets
  bool Join(int a, int b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace keypose
