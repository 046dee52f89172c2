// What the runner asks of time.
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
