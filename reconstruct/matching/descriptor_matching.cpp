#include "reconstruct/matching/descriptor_matching.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 128;
constexpr double kSquaredLength = 512.0 * 512.0;

constexpr int kLanes = 16;                    // descriptors side by side in a packed block
constexpr int kPackedBlock = kLanes * kSize;  // 16-bit numbers of a block
constexpr int kRows = 8;                      // descriptors of a for each pass over a block

/// Blocks of 16 descriptors with their dimensions interleaved in pairs, as the multiply-add
/// instruction needs them; zero-filled.
std::vector<std::int16_t> Packed(const Features& features) {
  const int blocks = (features.count() + kLanes - 1) / kLanes;
  std::vector<std::int16_t> packed(static_cast<std::size_t>(blocks) * kPackedBlock, 0);
  for (int j = 0; j < features.count(); ++j)
    for (int k = 0; k < kSize; ++k)
      packed[static_cast<std::size_t>(j / kLanes) * kPackedBlock +
             static_cast<std::size_t>((k / 2) * 2 * kLanes + (j % kLanes) * 2 + k % 2)] =
          features.descriptors[static_cast<std::size_t>(j) * kSize + static_cast<std::size_t>(k)];
  return packed;
}

struct Dots {
  alignas(64) std::int32_t value[kRows][kLanes];
  std::uint32_t above[kRows];  ///< bit for each lane whose value exceeds the least relevant one
};

using DotBlock = void (*)(const std::int16_t* const rows[kRows], const std::int16_t* block,
                          std::int32_t least, Dots& dots);

/// Dot products of 8 descriptors with the 16 of a block.
void DotBlockPortable(const std::int16_t* const rows[kRows], const std::int16_t* block,
                      std::int32_t least, Dots& dots) {
  for (int r = 0; r < kRows; ++r) {
    for (int lane = 0; lane < kLanes; ++lane) dots.value[r][lane] = 0;
    for (int k = 0; k < kSize; k += 2)
      for (int lane = 0; lane < kLanes; ++lane)
        dots.value[r][lane] += rows[r][k] * block[k * kLanes + 2 * lane] +
                               rows[r][k + 1] * block[k * kLanes + 2 * lane + 1];
    dots.above[r] = 0;
    for (int lane = 0; lane < kLanes; ++lane)
      dots.above[r] |= static_cast<std::uint32_t>(dots.value[r][lane] > least) << lane;
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void DotBlockAvx2(const std::int16_t* const rows[kRows],
                                                  const std::int16_t* block, std::int32_t least,
                                                  Dots& dots) {
  constexpr int kHalf = kRows / 2;  // as many sums as there are registers
  for (int start = 0; start < kRows; start += kHalf) {
    __m256i sums[kHalf][2];
    for (auto& row : sums) row[0] = row[1] = _mm256_setzero_si256();
    for (int k = 0; k < kSize; k += 2) {
      const auto* at = reinterpret_cast<const __m256i*>(block + k * kLanes);
      const __m256i low = _mm256_loadu_si256(at), high = _mm256_loadu_si256(at + 1);
      for (int r = 0; r < kHalf; ++r) {
        std::int32_t two;
        std::memcpy(&two, rows[start + r] + k, sizeof two);
        const __m256i both = _mm256_set1_epi32(two);
        sums[r][0] = _mm256_add_epi32(sums[r][0], _mm256_madd_epi16(both, low));
        sums[r][1] = _mm256_add_epi32(sums[r][1], _mm256_madd_epi16(both, high));
      }
    }
    for (int r = 0; r < kHalf; ++r) {
      dots.above[start + r] = 0;
      for (int h = 0; h < 2; ++h) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(dots.value[start + r] + 8 * h), sums[r][h]);
        const int mask = _mm256_movemask_ps(
            _mm256_castsi256_ps(_mm256_cmpgt_epi32(sums[r][h], _mm256_set1_epi32(least))));
        dots.above[start + r] |= static_cast<std::uint32_t>(mask) << (8 * h);
      }
    }
  }
}

__attribute__((target("avx512f,avx512vnni"))) void DotBlockVnni(
    const std::int16_t* const rows[kRows], const std::int16_t* block, std::int32_t least,
    Dots& dots) {
  __m512i sums[kRows];
  for (__m512i& sum : sums) sum = _mm512_setzero_si512();
  for (int k = 0; k < kSize; k += 2) {
    const __m512i lanes = _mm512_loadu_si512(block + k * kLanes);
    for (int r = 0; r < kRows; ++r) {
      std::int32_t two;
      std::memcpy(&two, rows[r] + k, sizeof two);
      sums[r] = _mm512_dpwssd_epi32(sums[r], _mm512_set1_epi32(two), lanes);
    }
  }
  for (int r = 0; r < kRows; ++r) {
    _mm512_storeu_si512(dots.value[r], sums[r]);
    dots.above[r] = _mm512_cmpgt_epi32_mask(sums[r], _mm512_set1_epi32(least));
  }
}
#endif

DotBlock ChooseDotBlock() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512vnni")) return DotBlockVnni;
  if (__builtin_cpu_supports("avx2")) return DotBlockAvx2;
#endif
  return DotBlockPortable;
}

/// A descriptor with a smaller dot product is neither a match, nor a second nearest that fails the
/// ratio test.
int LeastDot(const MatchOptions& options) {
  const double widest = std::min(1.5707963267948966, options.max_distance / options.max_ratio);
  return static_cast<int>(std::floor(std::cos(widest) * kSquaredLength)) - 1;
}

bool Passes(const NearestTwo& best, const MatchOptions& options) {
  if (best.index < 0) return false;
  const auto angle = [](int dot) {
    return std::acos(std::min(1.0, std::max(0, dot) / kSquaredLength));
  };
  const double nearest = angle(best.dot);
  return nearest <= options.max_distance && nearest < options.max_ratio * angle(best.second);
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> MutualMatches(
    const std::vector<NearestTwo>& of_a, const std::vector<NearestTwo>& of_b,
    const MatchOptions& options) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (!Passes(of_a[i], options)) continue;
    const NearestTwo& back = of_b[of_a[i].index];
    if (back.index == static_cast<int>(i) && Passes(back, options))
      matches.emplace_back(static_cast<std::uint32_t>(i),
                           static_cast<std::uint32_t>(of_a[i].index));
  }
  return matches;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchDescriptors(const Features& a,
                                                                      const Features& b,
                                                                      const MatchOptions& options) {
  constexpr int kTile = 48;  // blocks of b that stay in the cache during a pass over a
  static const DotBlock dot_block = ChooseDotBlock();
  std::vector<NearestTwo> of_a(static_cast<std::size_t>(a.count())),
      of_b(static_cast<std::size_t>(b.count()));
  const std::vector<std::int16_t> packed = Packed(b);
  const int blocks = (b.count() + kLanes - 1) / kLanes, least = std::max(0, LeastDot(options));
  Dots dots;
  for (int tile = 0; tile < blocks; tile += kTile)
    for (int i = 0; i < a.count(); i += kRows) {
      const int rows_here = std::min(kRows, a.count() - i);
      const std::int16_t* rows[kRows];
      for (int r = 0; r < kRows; ++r)
        rows[r] = a.descriptors.data() +
                  static_cast<std::ptrdiff_t>(i + std::min(r, rows_here - 1)) * kSize;
      for (int block = tile; block < std::min(blocks, tile + kTile); ++block) {
        dot_block(rows, packed.data() + static_cast<std::ptrdiff_t>(block) * kPackedBlock, least,
                  dots);
        for (int r = 0; r < rows_here; ++r)
          for (std::uint32_t above = dots.above[r]; above != 0; above &= above - 1) {
            const int lane = std::countr_zero(above), j = block * kLanes + lane;
            if (j >= b.count()) continue;
            of_a[i + r].Offer(dots.value[r][lane], j);
            of_b[j].Offer(dots.value[r][lane], i + r);
          }
      }
    }
  return MutualMatches(of_a, of_b, options);
}

Features LargestFeatures(const Features& features, int count) {
  std::vector<int> order(static_cast<std::size_t>(features.count()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return features.scales(i) > features.scales(j); });
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  std::sort(order.begin(), order.end());
  Features largest;
  largest.positions.resize(std::ssize(order), 2);
  largest.scales.resize(std::ssize(order));
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest.positions.row(k) = features.positions.row(order[k]);
    largest.scales(static_cast<Eigen::Index>(k)) = features.scales(order[k]);
    const auto from = features.descriptors.begin() + static_cast<std::ptrdiff_t>(order[k]) * kSize;
    largest.descriptors.insert(largest.descriptors.end(), from, from + kSize);
  }
  return largest;
}

}  // namespace keypose::reconstruct
