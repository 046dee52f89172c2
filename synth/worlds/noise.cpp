#include "synth/worlds/noise.h"

#include <cmath>

namespace keypose::synth {
namespace {

std::uint32_t LatticeHash(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^
                    static_cast<std::uint32_t>(y) * 0xd8163841u ^
                    static_cast<std::uint32_t>(z) * 0xcb1ab31fu ^ seed * 0x9e3779b1u;
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return h ^ h >> 16;
}

// The twelve edge directions of a cube, four of them twice: no preferred axis, and dot products
// need only additions.
constexpr signed char kEdges[16][3] = {
    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
    {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}, {1, 1, 0}, {-1, 1, 0}, {0, -1, 1}, {0, -1, -1}};

}  // namespace

std::uint64_t Hash(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  return x ^ x >> 31;
}

double Random::Uniform() {
  state_ += 0x9e3779b97f4a7c15ULL;
  return static_cast<double>(Hash(state_) >> 11) * 0x1.0p-53;
}

double Random::Normal() {
  const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
  return radius * std::cos(6.283185307179586 * Uniform());
}

double GradientNoise(const Eigen::Vector3d& x, std::uint32_t seed, Eigen::Vector3d* gradient) {
  const double floors[3] = {std::floor(x[0]), std::floor(x[1]), std::floor(x[2])};
  const int cell[3] = {static_cast<int>(floors[0]), static_cast<int>(floors[1]),
                       static_cast<int>(floors[2])};
  double t[3], fade[3], slope[3];
  for (int k = 0; k < 3; ++k) {
    t[k] = x[k] - floors[k];
    fade[k] = t[k] * t[k] * t[k] * (t[k] * (t[k] * 6 - 15) + 10);
    slope[k] = 30 * t[k] * t[k] * (t[k] - 1) * (t[k] - 1);
  }
  double value = 0, derivative[3] = {0, 0, 0};
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const signed char* g = kEdges[LatticeHash(cell[0] + i, cell[1] + j, cell[2] + k, seed) & 15];
    const double dot = g[0] * (t[0] - i) + g[1] * (t[1] - j) + g[2] * (t[2] - k);
    const double wx = i ? fade[0] : 1 - fade[0], wy = j ? fade[1] : 1 - fade[1],
                 wz = k ? fade[2] : 1 - fade[2];
    const double weight = wx * wy * wz;
    value += weight * dot;
    if (!gradient) continue;
    derivative[0] += weight * g[0] + dot * (i ? slope[0] : -slope[0]) * wy * wz;
    derivative[1] += weight * g[1] + dot * (j ? slope[1] : -slope[1]) * wx * wz;
    derivative[2] += weight * g[2] + dot * (k ? slope[2] : -slope[2]) * wx * wy;
  }
  if (gradient) *gradient = Eigen::Vector3d(derivative[0], derivative[1], derivative[2]);
  return value;
}

double FractalNoise(const Eigen::Vector3d& x, int octaves, double gain, std::uint32_t seed) {
  double sum = 0, height = 1, frequency = 1;
  for (int i = 0; i < octaves; ++i, height *= gain, frequency *= 2)
    sum += height * GradientNoise(frequency * x, seed + 101u * static_cast<std::uint32_t>(i));
  return sum;
}

}  // namespace keypose::synth
