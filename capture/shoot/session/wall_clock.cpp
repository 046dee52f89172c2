#include "capture/shoot/session/wall_clock.h"

#include <chrono>

namespace keypose::capture::shoot {

std::int64_t SystemClock::Now() const {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::seconds>(since).count();
}

}  // namespace keypose::capture::shoot
