// An end of searches by rays that would go on for ever.
#pragma once

#include <stdexcept>

namespace keypose::registration {

/// Counts the rays from a point that did not tell whether it is inside.
class RayPatience {
 public:
  /// @param first  the point's first ray
  /// @throws std::runtime_error  more than a hundred followed it
  void Cast(bool first) {
    constexpr int kMostOthers = 100;
    others_ = first ? 0 : others_ + 1;
    if (others_ > kMostOthers)
      throw std::runtime_error("CGAL cannot decide whether a point is inside");
  }

 private:
  int others_ = 0;
};

}  // namespace keypose::registration
