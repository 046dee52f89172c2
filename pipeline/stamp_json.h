// How the state files remember that a file is as it was: size, times and inode.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/disk.h"

namespace keypose::pipeline {

inline nlohmann::json StampOf(const FileStat& stat) {
  return {stat.size, stat.mtime_ns, stat.ctime_ns, stat.inode};
}

}  // namespace keypose::pipeline
