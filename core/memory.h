// Checks for free memory before a large allocation.
#pragma once

#include <cstdint>
#include <string>

namespace keypose {

/// Bytes that this process can still allocate: the smallest of the system's free memory, the limit
/// of its control group and its own limit (ulimit -v). Values that cannot be read are ignored.
std::int64_t FreeMemory();

/// @param what  what needs the memory, for the message: the file's name and its size
/// @throws DiskError  `bytes` is more than FreeMemory()
void RequireMemory(std::int64_t bytes, const std::string& what);

}  // namespace keypose
