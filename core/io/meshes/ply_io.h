// PLY files as tables of numbers; mesh_io.h builds on it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace keypose {

/// How a number is stored.
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// All lists of one property, concatenated: row i is values[offsets[i] .. offsets[i+1]).
struct PlyList {
  std::vector<std::size_t> offsets{0};
  std::vector<double> values;
};

/// Names of properties are in small letters.
struct PlyElement {
  std::size_t count = 0;
  std::map<std::string, std::vector<double>> scalars;  ///< each `count` long
  std::map<std::string, PlyList> lists;
  std::map<std::string, PlyType> types;  ///< of the scalars
  bool Has(const std::string& property) const { return scalars.count(property) > 0; }
};

/// By the elements' names in small letters.
using PlyTable = std::map<std::string, PlyElement>;

/// Reads ASCII and both byte orders, any type of numbers and of list lengths, names of any case,
/// and in ASCII values that are spread over lines as they like. Of binary `float rgb` and `rgba`
/// the bits are read, as kUint32.
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed or truncated; says the line and the reason
PlyTable ReadPly(const std::filesystem::path& path);

/// The values of `comment KEY VALUE` and `obj_info KEY VALUE` lines of the header, in their order.
/// @param key  in small letters; that of the file may be of any case
/// @throws DiskError  cannot be opened
std::vector<std::string> PlyNotes(const std::filesystem::path& path, const std::string& key);

}  // namespace keypose
