// The numbers of a glTF: accessors as matrices, unpacked (meshopt, Draco), with sparse entries in
// their places.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>

#include "core/io/meshes/gltf_file.h"

namespace keypose {

/// Numbers of an accessor, one row each.
using GltfRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class GltfData {
 public:
  /// @param file  must outlive this object
  explicit GltfData(const GltfFile& file) : file_(file) {}

  /// Integers that are normalised become -1 to 1, or 0 to 1.
  /// @throws InputError  no such accessor, data that the file does not have, numbers of an unknown
  ///                     kind
  GltfRows Numbers(int accessor);

  /// The bytes of a view. A packed one is unpacked at its first use.
  /// @throws InputError  beyond its buffer; meshopt data of a kind that the library does not read
  std::string_view Bytes(int view);

  /// Whether a part's numbers come from Draco: it has such data, and nothing beside it.
  bool IsDraco(const GltfPrimitive& part) const;

  /// A part's attributes and corners, as Draco packed them.
  struct Unpacked {
    std::map<std::string, GltfRows> attributes;
    GltfRows corners;  ///< 3 F x 1
  };
  /// @throws InputError  Draco's library does not read them
  Unpacked Draco(const GltfPrimitive& part);

 private:
  std::string Unpack(const GltfPacked& packed, std::size_t length) const;
  std::string_view Slice(int buffer, std::size_t offset, std::size_t length) const;
  GltfRows Stored(int view, std::size_t offset, std::size_t count, int columns, int component,
                  bool normalized);
  void PutSparse(const GltfAccessor& accessor, GltfRows* rows);

  const GltfFile& file_;
  std::map<int, std::string> unpacked_;  ///< by view
};

}  // namespace keypose
