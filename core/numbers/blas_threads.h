// The number of threads that dense linear algebra uses.
#pragma once

namespace keypose {

/// From this call on, OpenBLAS uses the calling thread only, so that sums in its kernels do not
/// depend on the number of threads. A program that links this file calls it before main, because
/// OpenBLAS starts its threads when it is loaded, and they use processor time for about 30 ms
/// before they sleep.
void UseOneBlasThread();

}  // namespace keypose
