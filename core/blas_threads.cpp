#include "core/blas_threads.h"

#include <dlfcn.h>

extern "C" void openblas_set_num_threads(int threads);

namespace keypose {

void UseOneBlasThread() {
  // Once and no more: to set the number again would bring the threads back.
  static const bool once = [] {
    openblas_set_num_threads(1);
    // What OpenBLAS itself calls before a fork. Looked up at run time, since its headers do not
    // declare it.
    using Shutdown = int (*)();
    if (const auto shutdown =
            reinterpret_cast<Shutdown>(dlsym(RTLD_DEFAULT, "blas_thread_shutdown_")))
      shutdown();
    return true;
  }();
  static_cast<void>(once);
}

namespace {
const bool kAtStart = (UseOneBlasThread(), true);
}

}  // namespace keypose
