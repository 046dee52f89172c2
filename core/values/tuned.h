// Constants whose values were chosen by trying them on data.
//
// They stand in one struct per algorithm, each with its unit and its meaning; the struct's comment
// names the data. bench/sensitivity.py halves and doubles each of them and measures how the result
// changes (docs/results/sensitivity.md).
#pragma once

#ifdef KEYPOSE_SENSITIVITY

// Built for bench/sensitivity.py. Two environment variables act on such programs:
//
//   KEYPOSE_TUNED=FILE:NAME=VALUE   replaces one constant
//   KEYPOSE_TUNED_READ=FILE         is told which constants a program reads, one a line
//

#include "core/values/tuned_constant.h"

#define KEYPOSE_TUNED(type, name, value) \
  static inline const type& name = ::keypose::TunedConstant<type>(__FILE__, #name, value)

#else

#define KEYPOSE_TUNED(type, name, value) static constexpr type name = value

#endif
