// What each part of a stage's work cost.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "core/stage/stage.h"

namespace keypose::reconstruct {

/// Seconds and CPU seconds of each part of the work.
class Stopwatch {
 public:
  void Lap(StageContext& stage, const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    const double cpu = CpuSeconds();
    auto& [seconds, cpu_seconds] = spent_[name];
    seconds += std::chrono::duration<double>(now - last_).count();
    cpu_seconds += cpu - last_cpu_;
    stage.Report("seconds_" + name, seconds);
    stage.Report("cpu_seconds_" + name, cpu_seconds);
    last_ = now;
    last_cpu_ = cpu;
  }

 private:
  /// Of this process and of the programs that it has run.
  static double CpuSeconds() {
    double seconds = 0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
      rusage usage{};
      getrusage(who, &usage);
      seconds += usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + 1e-6 * (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    }
    return seconds;
  }

  double last_cpu_ = CpuSeconds();
  std::map<std::string, std::pair<double, double>> spent_;  ///< what is done twice adds up
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace keypose::reconstruct
