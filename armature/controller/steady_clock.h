// Seconds since some moment; they never run backwards.
#pragma once

#include <chrono>

namespace keypose::armature {

inline double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace keypose::armature
