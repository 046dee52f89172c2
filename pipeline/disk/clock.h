// The runner's interface to the clock.
#pragma once

namespace keypose::pipeline {

class Clock {
 public:
  virtual ~Clock() = default;
  /// Seconds since 1970, UTC.
  virtual double Now() const = 0;
};

class RealClock final : public Clock {
 public:
  double Now() const override;
};

}  // namespace keypose::pipeline
