// Vectors of four doubles, with the elementary functions that the interpolation of faces needs.
//
// Everything here is compiled twice: in the namespace `plain` for any processor, and in `fused` for
// processors with AVX2 and fused multiply-add. Kernels that use it are compiled twice as well: each
// is in a separate file that is included in both namespaces, the second time between
// KEYPOSE_FUSED_BEGIN and KEYPOSE_FUSED_END. A target attribute on the outermost function is not
// enough: GCC 12 splits vectors in inlined functions before it knows the target.
#pragma once

#include <cstdint>

namespace keypose {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // everything here is inlined: no vector crosses a call

using Lanes = double __attribute__((vector_size(32)));
using LaneBits = std::int64_t __attribute__((vector_size(32)));

#define KEYPOSE_INLINE inline __attribute__((always_inline))

/// Whether this processor can run `fused`.
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
