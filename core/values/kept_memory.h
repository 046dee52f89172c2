// What a program has freed stays with it.
#pragma once

namespace keypose {

/// Freed blocks of up to 32 MiB are kept for the next ones instead of being given back to the
/// system and asked for again: each page of those costs a fault, which is a third of the time of a
/// stage on small pictures. Larger blocks go back at once, and so does what is free at the end of
/// the heap beyond 128 MiB. For the main function of a program, before it starts a thread. Does
/// nothing where the C library is not glibc.
void KeepFreedMemory();

}  // namespace keypose
