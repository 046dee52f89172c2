// Checks for free memory before a large allocation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// Bytes that this process can still allocate: the smallest of the system's free memory, the limit
/// of its control group and its own limit (ulimit -v). Values that cannot be read are ignored.
std::int64_t FreeMemory();

/// @param what  what needs the memory, for the message: the file's name and its size
/// @throws DiskError  `bytes` is more than FreeMemory()
void RequireMemory(std::int64_t bytes, const std::string& what);

/// What a stage needs for all its photographs together, said before they are read.
///
/// @param stage          its name, for the message
/// @param scale          size of the pictures that it works on, relative to the photographs
/// @param bytes_a_pixel  measured peak, per pixel of these pictures
/// @throws DiskError  as RequireMemory
void RequireMemoryForViews(const std::string& stage, const std::vector<View>& views, double scale,
                           double bytes_a_pixel);

}  // namespace keypose
