// The time of day, so that a simulated session can have one of its own.
#pragma once

#include <cstdint>

namespace keypose::capture::shoot {

class WallClock {
 public:
  virtual ~WallClock() = default;
  /// Seconds since 1970.
  virtual std::int64_t Now() const = 0;
};

class SystemClock final : public WallClock {
 public:
  std::int64_t Now() const override;
};

}  // namespace keypose::capture::shoot
