// How a device waits, so that the person is heard meanwhile.
#pragma once

namespace keypose::capture::shoot {

/// Waits for a device. Whoever made it may throw from Wait to give up what is under way.
class Patience {
 public:
  virtual ~Patience() = default;
  /// Lets `seconds` go by; 0 only looks whether to give up.
  virtual void Wait(double seconds) = 0;
  /// Seconds since some moment; never runs backwards.
  virtual double Now() const = 0;
};

/// Only waits.
class PlainPatience final : public Patience {
 public:
  void Wait(double seconds) override;
  double Now() const override;
};

}  // namespace keypose::capture::shoot
