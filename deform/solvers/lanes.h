// Four doubles at a time, with the elementary functions that faces' paths need.
//
// All of it is compiled twice, in namespaces `plain` for any processor and `fused` for those with
// AVX2 and fused multiply-add, and so are the kernels that use it: each in a file of its own that
// is included in both, between KEYPOSE_FUSED_BEGIN and KEYPOSE_FUSED_END the second time. A target
// attribute on the outermost function would not do: GCC 12 takes vectors in what it inlines apart
// before it knows the target.
#pragma once

#include <cstdint>

namespace keypose {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // everything here is inlined: no vector crosses a call

using Lanes = double __attribute__((vector_size(32)));
using LaneBits = std::int64_t __attribute__((vector_size(32)));

#define KEYPOSE_INLINE inline __attribute__((always_inline))

/// Whether `fused` runs here.
inline bool HasFused() {
#if defined(__x86_64__)
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return has;
#else
  return false;
#endif
}

#if defined(__x86_64__)
#define KEYPOSE_FUSED_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2,fma\")")
#define KEYPOSE_FUSED_END _Pragma("GCC pop_options")
#else
#define KEYPOSE_FUSED_BEGIN
#define KEYPOSE_FUSED_END
#endif

namespace plain {
#include "deform/solvers/lanes.inc"
}
KEYPOSE_FUSED_BEGIN
namespace fused {
#include "deform/solvers/lanes.inc"
}
KEYPOSE_FUSED_END

#pragma GCC diagnostic pop

}  // namespace keypose
