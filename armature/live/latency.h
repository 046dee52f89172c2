// How long things took, as the share of them that was faster.
#pragma once

#include <vector>

namespace keypose::armature {

class Latency {
 public:
  void Add(double seconds) { seconds_.push_back(seconds); }
  int count() const { return static_cast<int>(seconds_.size()); }
  /// The value that a share of all does not exceed; 0 if there are none.
  /// @param share  0 to 1; 0.5 is the median, 1 the worst
  double At(double share) const;

 private:
  std::vector<double> seconds_;
};

/// Processor time of this process so far, of all its threads [s].
double ProcessorSeconds();

}  // namespace keypose::armature
