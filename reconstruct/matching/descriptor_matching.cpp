#include "reconstruct/matching/descriptor_matching.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 128;
constexpr double kSquaredLength = 512.0 * 512.0;

constexpr int kLanes = 16;                    // descriptors side by side in a packed block
constexpr int kPackedBlock = kLanes * kSize;  // numbers of a block
constexpr int kRows = 16;                     // descriptors of a for each pass over a block

/// Values that the dot products with descriptors of a block must exceed to tell anything.
struct Limits {
  std::int32_t of_row[kRows];
  const std::int32_t* of_lane;  ///< of the block's 16 descriptors
};

struct Dots {
  alignas(64) std::int32_t value[kRows][kLanes];
  std::uint32_t above[kRows];  ///< bit for each lane whose value exceeds the row's or its own limit
};

/// Descriptors in blocks of 16 with so many dimensions of each side by side as one instruction
/// multiplies and adds; zero-filled.
template <class T>
std::vector<T> PackedBlocks(const Features& features, int together) {
  const int blocks = (features.count() + kLanes - 1) / kLanes;
  std::vector<T> packed(static_cast<std::size_t>(blocks) * kPackedBlock, 0);
  for (int j = 0; j < features.count(); ++j)
    for (int k = 0; k < kSize; ++k)
      packed[static_cast<std::size_t>(j / kLanes) * kPackedBlock +
             static_cast<std::size_t>(k / together * together * kLanes + j % kLanes * together +
                                      k % together)] =
          static_cast<T>(features.descriptors[static_cast<std::size_t>(j) * kSize +
                                              static_cast<std::size_t>(k)]);
  return packed;
}

/// Dot products of 16 descriptors with those of a block.
void DotBlockPortable(const std::int16_t* const rows[kRows], const std::int16_t* block,
                      const Limits& limits, Dots& dots) {
  for (int r = 0; r < kRows; ++r) {
    for (int lane = 0; lane < kLanes; ++lane) dots.value[r][lane] = 0;
    for (int k = 0; k < kSize; k += 2)
      for (int lane = 0; lane < kLanes; ++lane)
        dots.value[r][lane] += rows[r][k] * block[k * kLanes + 2 * lane] +
                               rows[r][k + 1] * block[k * kLanes + 2 * lane + 1];
    dots.above[r] = 0;
    for (int lane = 0; lane < kLanes; ++lane)
      dots.above[r] |= static_cast<std::uint32_t>(dots.value[r][lane] >
                                                  std::min(limits.of_row[r], limits.of_lane[lane]))
                       << lane;
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void DotBlockAvx2(const std::int16_t* const rows[kRows],
                                                  const std::int16_t* block, const Limits& limits,
                                                  Dots& dots) {
  constexpr int kPart = 4;  // as many sums as there are registers
  const auto* lane_limits = reinterpret_cast<const __m256i*>(limits.of_lane);
  for (int start = 0; start < kRows; start += kPart) {
    __m256i sums[kPart][2];
    for (auto& row : sums) row[0] = row[1] = _mm256_setzero_si256();
    for (int k = 0; k < kSize; k += 2) {
      const auto* at = reinterpret_cast<const __m256i*>(block + k * kLanes);
      const __m256i low = _mm256_loadu_si256(at), high = _mm256_loadu_si256(at + 1);
      for (int r = 0; r < kPart; ++r) {
        std::int32_t two;
        std::memcpy(&two, rows[start + r] + k, sizeof two);
        const __m256i both = _mm256_set1_epi32(two);
        sums[r][0] = _mm256_add_epi32(sums[r][0], _mm256_madd_epi16(both, low));
        sums[r][1] = _mm256_add_epi32(sums[r][1], _mm256_madd_epi16(both, high));
      }
    }
    for (int r = 0; r < kPart; ++r) {
      dots.above[start + r] = 0;
      for (int h = 0; h < 2; ++h) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(dots.value[start + r] + 8 * h), sums[r][h]);
        const __m256i limit = _mm256_min_epi32(_mm256_set1_epi32(limits.of_row[start + r]),
                                               _mm256_loadu_si256(lane_limits + h));
        const int mask =
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(sums[r][h], limit)));
        dots.above[start + r] |= static_cast<std::uint32_t>(mask) << (8 * h);
      }
    }
  }
}

/// With 8-bit numbers, one side signed: rows are less by 128, which adds 128 times the sum of a
/// descriptor of the block.
__attribute__((target("avx512f,avx512vnni"))) void DotBlockVnni(
    const std::int8_t* const rows[kRows], const std::uint8_t* block, const Limits& limits,
    Dots& dots) {
  const __m512i offset = _mm512_set1_epi32(static_cast<int>(0x80808080U));
  __m512i lanes_sum = _mm512_setzero_si512();  // -128 times a lane's sum
  __m512i sums[kRows];
  for (__m512i& sum : sums) sum = _mm512_setzero_si512();
  for (int k = 0; k < kSize; k += 4) {
    const __m512i lanes = _mm512_loadu_si512(block + k * kLanes);
    lanes_sum = _mm512_dpbusd_epi32(lanes_sum, lanes, offset);
    for (int r = 0; r < kRows; ++r) {
      std::int32_t four;
      std::memcpy(&four, rows[r] + k, sizeof four);
      sums[r] = _mm512_dpbusd_epi32(sums[r], lanes, _mm512_set1_epi32(four));
    }
  }
  const __m512i lane_limits = _mm512_loadu_si512(limits.of_lane);
  for (int r = 0; r < kRows; ++r) {
    const __m512i sum = _mm512_sub_epi32(sums[r], lanes_sum);
    _mm512_storeu_si512(dots.value[r], sum);
    dots.above[r] = static_cast<std::uint32_t>(
        _mm512_cmpgt_epi32_mask(sum, lane_limits) |
        _mm512_cmpgt_epi32_mask(sum, _mm512_set1_epi32(limits.of_row[r])));
  }
}
#endif

/// A descriptor with a smaller dot product is neither a match, nor a second nearest that fails the
/// ratio test.
int LeastDot(const MatchOptions& options) {
  const double widest = std::min(1.5707963267948966, options.max_distance / options.max_ratio);
  return static_cast<int>(std::floor(std::cos(widest) * kSquaredLength)) - 1;
}

/// The two nearest of each descriptor in the other set, of those nearer than `least`.
struct Nearest {
  std::vector<NearestTwo> of_a, of_b;
};

/// @param rows    descriptors of a, 128 numbers each
/// @param blocks  those of b, as PackedBlocks gives them
template <class Row, class Lane>
Nearest FindNearest(void (*dot_block)(const Row* const rows[kRows], const Lane* block,
                                      const Limits& limits, Dots& dots),
                    const std::vector<Row>& rows, const std::vector<Lane>& blocks, int count_b,
                    int least) {
  constexpr int kTile = 48;  // blocks that stay in the cache during a pass over a
  const int count_a = SizeOf(rows) / kSize, block_count = SizeOf(blocks) / kPackedBlock;
  Nearest nearest{std::vector<NearestTwo>(static_cast<std::size_t>(count_a)),
                  std::vector<NearestTwo>(static_cast<std::size_t>(count_b))};
  std::vector<std::int32_t> lane_limits(static_cast<std::size_t>(block_count) * kLanes, least);
  Dots dots;
  for (int tile = 0; tile < block_count; tile += kTile)
    for (int i = 0; i < count_a; i += kRows) {
      const int rows_here = std::min(kRows, count_a - i);
      const Row* of_rows[kRows];
      Limits limits{};
      for (int r = 0; r < kRows; ++r) {
        const int row = i + std::min(r, rows_here - 1);
        of_rows[r] = rows.data() + static_cast<std::ptrdiff_t>(row) * kSize;
        limits.of_row[r] = std::max(least, nearest.of_a[row].second);
      }
      for (int block = tile; block < std::min(block_count, tile + kTile); ++block) {
        limits.of_lane = lane_limits.data() + static_cast<std::ptrdiff_t>(block) * kLanes;
        dot_block(of_rows, blocks.data() + static_cast<std::ptrdiff_t>(block) * kPackedBlock,
                  limits, dots);
        for (int r = 0; r < rows_here; ++r)
          for (std::uint32_t above = dots.above[r]; above != 0; above &= above - 1) {
            const int lane = std::countr_zero(above), j = block * kLanes + lane;
            if (j >= count_b) continue;
            NearestTwo &of_a = nearest.of_a[i + r], &of_b = nearest.of_b[j];
            of_a.Offer(dots.value[r][lane], j);
            of_b.Offer(dots.value[r][lane], i + r);
            limits.of_row[r] = std::max(least, of_a.second);
            lane_limits[j] = std::max(least, of_b.second);
          }
      }
    }
  return nearest;
}

Nearest FindNearest(const Features& a, const Features& b, int least) {
#if defined(__x86_64__)
  static const bool has_vnni = __builtin_cpu_supports("avx512vnni") != 0,
                    has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_vnni) {
    std::vector<std::int8_t> rows(a.descriptors.size());
    std::transform(a.descriptors.begin(), a.descriptors.end(), rows.begin(),
                   [](std::int16_t value) { return static_cast<std::int8_t>(value - 128); });
    return FindNearest(DotBlockVnni, rows, PackedBlocks<std::uint8_t>(b, 4), b.count(), least);
  }
  if (has_avx2)
    return FindNearest(DotBlockAvx2, a.descriptors, PackedBlocks<std::int16_t>(b, 2), b.count(),
                       least);
#endif
  return FindNearest(DotBlockPortable, a.descriptors, PackedBlocks<std::int16_t>(b, 2), b.count(),
                     least);
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
  const Nearest nearest = FindNearest(a, b, std::max(0, LeastDot(options)));
  return MutualMatches(nearest.of_a, nearest.of_b, options);
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
