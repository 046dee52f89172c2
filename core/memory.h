// What a step may take of the machine's memory, asked before it is taken.
#pragma once

#include <cstdint>
#include <string>

namespace keypose {

/// Bytes that this process may still take: the least of what the system has free, what its control
/// group allows and its own limit (ulimit -v). What cannot be asked does not count.
std::int64_t FreeMemory();

/// @param what  what needs it, for the message: the file's name and its size
/// @throws DiskError  `bytes` are more than FreeMemory()
void RequireMemory(std::int64_t bytes, const std::string& what);

}  // namespace keypose
