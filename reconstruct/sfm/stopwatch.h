// The time that each part of a stage takes.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "core/stage/stage.h"
#include "reconstruct/numerics/cpu_seconds.h"

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
  double last_cpu_ = CpuSeconds();
  std::map<std::string, std::pair<double, double>> spent_;  ///< repeated parts add up
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace keypose::reconstruct
