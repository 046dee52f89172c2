// The same net in two files, whose triangles differ.
#pragma once

#include <filesystem>
#include <limits>
#include <sstream>
#include <vector>

#include "core/io/text/files.h"
#include "core/values/mesh.h"

namespace keypose {

/// Writes an OBJ whose polygons are a mesh's triangles, but for the first two in turn that share an
/// edge: these are a quad, which begins at a corner across from that edge, so that it is read with
/// the other diagonal. Without texture coordinates.
inline void WriteWithOtherCut(const std::filesystem::path& path, const Mesh& mesh) {
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  const auto add_line = [&text](const char* key, const auto& numbers) {
    text << key;
    for (const auto number : numbers) text << ' ' << number;
    text << '\n';
  };
  const auto quad_at = [&mesh](int f) -> std::vector<int> {
    for (int k = 0; k < 9 && f + 1 < mesh.face_count(); ++k) {
      const auto a = [&](int i) { return mesh.faces(f, (k + i) % 3) + 1; };
      const auto b = [&](int i) { return mesh.faces(f + 1, (k / 3 + i) % 3) + 1; };
      if (a(1) == b(1) && a(2) == b(0)) return {a(0), a(1), b(2), a(2)};
    }
    return {};
  };
  for (const auto& point : mesh.points.rowwise()) add_line("v", point);
  bool joined = false;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const std::vector<int> quad = joined ? std::vector<int>() : quad_at(f);
    if (quad.empty()) {
      add_line("f", Eigen::RowVector3i(mesh.faces.row(f).array() + 1));
      continue;
    }
    add_line("f", quad);
    joined = true;
    ++f;  // both triangles are written
  }
  WriteFile(path, text.str());
}

}  // namespace keypose
