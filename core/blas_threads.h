// How many threads dense linear algebra takes.
#pragma once

namespace keypose {

/// OpenBLAS stays on the calling thread from now on: sums in its kernels must not depend on how
/// many threads share them. A program that links this does so before main: OpenBLAS starts its
/// threads when it is loaded, and they spin for some 30 ms before they sleep.
void UseOneBlasThread();

}  // namespace keypose
