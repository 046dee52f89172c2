// The queue of a search for shortest paths.
#pragma once

#include <cstddef>
#include <vector>

#include "core/values/size_of.h"

namespace keypose {

/// A bucket queue: vertices in order of insertion for each step of distance.
class StepQueue {
 public:
  explicit StepQueue(double steps_per_length) : steps_per_length_(steps_per_length), lines_(64) {}
  void Put(int vertex, double distance) {
    const auto step = static_cast<std::size_t>(distance * steps_per_length_);
    if (step >= lines_.size()) lines_.resize(2 * step);
    const int entry = SizeOf(entries_);
    entries_.push_back({distance, vertex, -1});
    Line& line = lines_[step];
    (line.first < 0 ? line.first : entries_[line.last].next) = entry;
    line.last = entry;
  }
  /// Calls visit(vertex, distance) step by step. `visit` may put more vertices into the current
  /// step or a later one.
  template <class Visit>
  void Run(const Visit& visit) {
    for (std::size_t step = 0; step < lines_.size(); ++step)
      for (int entry = lines_[step].first; entry >= 0; entry = entries_[entry].next) {
        const Entry now = entries_[entry];
        visit(now.vertex, now.distance);
      }
  }

 private:
  struct Entry {
    double distance;
    int vertex, next;
  };
  struct Line {
    int first = -1, last = -1;
  };
  double steps_per_length_;
  std::vector<Line> lines_;
  std::vector<Entry> entries_;
};

}  // namespace keypose
