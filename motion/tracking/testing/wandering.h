// Courses with noise of known size.
#pragma once

#include <random>
#include <vector>

#include "motion/body/body_pose.h"
#include "motion/tracking/body_outline.h"

namespace keypose::motion {

class Noise {
 public:
  explicit Noise(unsigned seed) : engine_(seed) {}
  double Draw() { return normal_(engine_); }
  DofVector Numbers() {
    DofVector numbers;
    for (double& x : numbers) x = Draw();
    return numbers;
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// A course whose acceleration changes by `jerk` a frame (standard deviation).
/// @param home  1: it is pulled back to zero slowly; 0: it goes where it goes
inline std::vector<double> Wandering(int frames, double jerk, double home, Noise* noise) {
  std::vector<double> course;
  double at = 0, speed = 0, acceleration = 0;
  for (int f = 0; f < frames; ++f) {
    course.push_back(at);
    acceleration += jerk * noise->Draw();
    acceleration -= home * (0.02 * at + 0.1 * speed + 0.2 * acceleration);
    speed += acceleration, at += speed;
  }
  return course;
}

}  // namespace keypose::motion
