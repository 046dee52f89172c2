// Constants whose values were chosen by trying them on data.
//
// They stand in one struct per algorithm, each with its unit and its meaning; the struct's comment names the data.
// bench/sensitivity.py halves and doubles each of them and measures how the result changes
// (docs/results/sensitivity.md).
#pragma once

#ifdef KEYPOSE_SENSITIVITY

namespace keypose {

/// The value of constant `name` in `file`, unless the environment variable KEYPOSE_TUNED is "FILE:NAME=VALUE" for
/// this one. FILE is relative to the project's folder. Only in builds for bench/sensitivity.py.
double TunedValue(const char* file, const char* name, double value);

}  // namespace keypose

#define KEYPOSE_TUNED(type, name, value) \
  static inline const type name = static_cast<type>(::keypose::TunedValue(__FILE__, #name, value))

#else

#define KEYPOSE_TUNED(type, name, value) static constexpr type name = value

#endif
