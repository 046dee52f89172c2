// Deterministic pseudo-random numbers and smooth 3D noise, for the grain of the clay and of the
// sensor.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace keypose::synth {

/// A 64-bit hash; the same on every machine.
std::uint64_t Hash(std::uint64_t x);

/// A small random generator: the same numbers for the same seed on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(Hash(seed + 0x9e3779b97f4a7c15ULL)) {}
  double Uniform();                                                       ///< [0, 1)
  double Uniform(double a, double b) { return a + (b - a) * Uniform(); }  ///< [a, b)
  int Below(int n) { return static_cast<int>(Uniform() * n); }            ///< 0 .. n-1
  double Normal();                                                        ///< mean 0, variance 1

 private:
  std::uint64_t state_;
};

/// Gradient noise on the unit lattice, in about [-1, 1], zero mean, C2. `gradient`, if not null,
/// receives the derivative. Source: Perlin, Improving Noise, SIGGRAPH 2002, with hashed gradients
/// instead of a table.
double GradientNoise(const Eigen::Vector3d& x, std::uint32_t seed,
                     Eigen::Vector3d* gradient = nullptr);

/// Sum of `octaves` noises, each with half the wavelength and `gain` times the height of the
/// previous one.
double FractalNoise(const Eigen::Vector3d& x, int octaves, double gain, std::uint32_t seed);

}  // namespace keypose::synth
