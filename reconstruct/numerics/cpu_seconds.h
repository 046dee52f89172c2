// Processor time.
#pragma once

#include <sys/resource.h>

namespace keypose::reconstruct {

/// User and system seconds of this process and of its finished child processes.
inline double CpuSeconds() {
  double seconds = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    seconds += static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
               1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  }
  return seconds;
}

}  // namespace keypose::reconstruct
