#include "armature/live/latency.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "core/values/size_of.h"

namespace keypose::armature {

double Latency::At(double share) const {
  if (seconds_.empty()) return 0;
  std::vector<double> sorted = seconds_;
  const int wanted = static_cast<int>(std::ceil(share * SizeOf(sorted))) - 1;
  const auto at = sorted.begin() + std::clamp(wanted, 0, SizeOf(sorted) - 1);
  std::nth_element(sorted.begin(), at, sorted.end());
  return *at;
}

double ProcessorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace keypose::armature
