// PLY files as tables of numbers; mesh_io.h builds on it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace keypose {

/// All lists of one property, concatenated: row i is values[offsets[i] .. offsets[i+1]).
struct PlyList {
  std::vector<std::size_t> offsets{0};
  std::vector<double> values;
};

struct PlyElement {
  std::size_t count = 0;
  std::map<std::string, std::vector<double>> scalars;  ///< each `count` long
  std::map<std::string, PlyList> lists;
  bool Has(const std::string& property) const { return scalars.count(property) > 0; }
};

using PlyTable = std::map<std::string, PlyElement>;

/// @throws InputError  malformed or truncated; says the line and the reason
PlyTable ReadPly(const std::filesystem::path& path);

}  // namespace keypose
