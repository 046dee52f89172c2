// Files that are damaged or malicious: each gives an error of the right kind that names it.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose {

namespace fs = std::filesystem;

class HostileFile : public ::testing::Test, public TestingFolder {
 protected:
  fs::path PutJpeg(const std::string& name, int width = 320, int height = 240) const {
    Image8 image(width, height, 3);
    for (std::size_t k = 0; k < image.data.size(); ++k)
      image.data[k] = static_cast<std::uint8_t>(k * k >> 4);
    WriteImage(folder_ / name, image);
    return folder_ / name;
  }

  /// The error's message, which must name the file.
  template <class Fault>
  static std::string Message(const fs::path& file, const std::function<void()>& read) {
    try {
      read();
      ADD_FAILURE() << file << " was read";
    } catch (const Fault& error) {
      EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos)
          << error.what();
      return error.what();
    }
    return "";
  }
  static std::string MeshMessage(const fs::path& file) {
    return Message<InputError>(file, [&] { ReadMesh(file); });
  }
  static std::string ImageMessage(const fs::path& file) {
    std::string info = Message<InputError>(file, [&] { ReadImageInfo(file); });
    EXPECT_EQ(info, Message<InputError>(file, [&] { ReadImage(file); }));
    return info;
  }
};

/// A lower bound of the peak memory that `work` adds to this process.
inline std::int64_t GrowthBytes(const std::function<void()>& work) {
  const auto peak = [] {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    return std::int64_t{1024} * use.ru_maxrss;
  };
  const std::int64_t before = peak();
  work();
  return peak() - before;
}

inline bool Says(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

inline std::string BigEndian32(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

using HostileMesh = HostileFile;

using HostileModel = HostileFile;

}  // namespace keypose
