// The constants of core/values/tuned.h in builds for bench/sensitivity.py: they can be changed from
// outside, and it is seen which of them a program reads.
#pragma once

#include <new>

namespace keypose {

/// The value of constant `name` in `file`, unless the environment variable KEYPOSE_TUNED is
/// "FILE:NAME=VALUE" for this one. FILE is relative to the project's folder.
double TunedValue(const char* file, const char* name, double value);

/// A page of memory for one constant.
void* TunedPage();

/// Makes the page constant. If the environment variable KEYPOSE_TUNED_READ names a file, the page
/// stays locked until it is first read, which appends "FILE:NAME" to that file.
void PublishTuned(void* page, const char* file, const char* name);

template <typename T>
const T& TunedConstant(const char* file, const char* name, double value) {
  void* page = TunedPage();
  const T* constant = new (page) T(static_cast<T>(TunedValue(file, name, value)));
  PublishTuned(page, file, name);
  return *constant;
}

}  // namespace keypose
