// Polygons of mesh files as triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Splits polygons into fans of triangles. Polygons with fewer than three corners are dropped.
class Fan {
 public:
  /// @param path  for messages
  Fan(const std::filesystem::path& path, std::int64_t vertex_count)
      : path_(path), vertex_count_(vertex_count) {}

  /// @throws InputError  a corner is no vertex; PLY may hold fractions, NaN and infinity
  template <class Corner>
  void Add(const Corner* corners, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) Check(static_cast<double>(corners[k]));
    for (std::size_t k = 1; k + 1 < count; ++k)
      triangles_.push_back({static_cast<int>(corners[0]), static_cast<int>(corners[k]),
                            static_cast<int>(corners[k + 1])});
    ++polygons_;
  }
  FacesX3 Take() const;

 private:
  void Check(double corner) const {
    if (!(corner >= 0 && corner < static_cast<double>(vertex_count_))) Refuse(corner);
  }
  [[noreturn]] void Refuse(double corner) const;

  const std::filesystem::path& path_;
  std::int64_t vertex_count_;
  std::size_t polygons_ = 0;
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace keypose
