#include "capture/shoot/devices/patience.h"

#include <chrono>
#include <thread>

namespace keypose::capture::shoot {

void PlainPatience::Wait(double seconds) {
  if (seconds > 0) std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

double PlainPatience::Now() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace keypose::capture::shoot
