#include "core/numbers/blas_threads.h"

#include <dlfcn.h>

extern "C" void openblas_set_num_threads(int threads);

namespace keypose {

void UseOneBlasThread() {
  // Only once: setting the number again would start the threads again.
  static const bool once = [] {
    openblas_set_num_threads(1);
    // OpenBLAS itself calls this function before a fork. Its headers do not declare it, so it is
    // looked up at run time.
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
