// A file's stamp in the state files: size, times and inode. An unchanged stamp means an unchanged
// file.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

inline nlohmann::json StampOf(const FileStat& stat) {
  return {stat.size, stat.mtime_ns, stat.ctime_ns, stat.inode};
}

}  // namespace keypose::pipeline
