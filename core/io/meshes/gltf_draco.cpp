#include "core/io/meshes/gltf_draco.h"

#include <draco/compression/decode.h>

#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>

namespace keypose {
namespace {

/// What white is in integers of this type; 1 of others.
double LargestOf(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    default:
      return 1;
  }
}

bool IsReal(draco::DataType type) { return type == draco::DT_FLOAT32 || type == draco::DT_FLOAT64; }

/// Puts one vertex's numbers into a row. @return whether the library could convert them
template <class T>
bool TakeRow(const draco::PointAttribute& attribute, draco::AttributeValueIndex value, double scale,
             double* row) {
  std::array<T, 16> numbers{};
  const auto components = static_cast<std::int8_t>(attribute.num_components());
  if (!attribute.ConvertValue<T>(value, components, numbers.data())) return false;
  for (int c = 0; c < components; ++c)
    row[c] = scale * static_cast<double>(numbers[static_cast<std::size_t>(c)]);
  return true;
}

bool TakeAttribute(const draco::PointAttribute& attribute, std::uint32_t points, bool normalized,
                   DracoMesh::Rows* rows) {
  if (attribute.num_components() < 1 || attribute.num_components() > 16) return false;
  rows->resize(points, attribute.num_components());
  const bool real = IsReal(attribute.data_type());
  const double scale = normalized && !real ? 1 / LargestOf(attribute.data_type()) : 1;
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute.size()) return false;
    double* row = rows->data() + static_cast<Eigen::Index>(i) * rows->cols();
    const bool taken = real ? TakeRow<float>(attribute, value, scale, row)
                            : TakeRow<std::int64_t>(attribute, value, scale, row);
    if (!taken) return false;
  }
  return true;
}

void TakeCorners(const draco::Mesh& mesh, DracoMesh::Rows* corners) {
  corners->resize(3 * static_cast<Eigen::Index>(mesh.num_faces()), 1);
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f)
    for (int k = 0; k < 3; ++k)
      (*corners)(3 * static_cast<Eigen::Index>(f) + k, 0) =
          mesh.face(draco::FaceIndex(f))[static_cast<std::size_t>(k)].value();
}

}  // namespace

std::string UnpackDraco(std::string_view bytes, const std::map<std::string, int>& ids,
                        const std::map<std::string, bool>& normalized, DracoMesh* mesh) try {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return decoded.status().error_msg_string();
  const std::unique_ptr<draco::Mesh> unpacked = std::move(decoded).value();
  TakeCorners(*unpacked, &mesh->corners);
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* attribute =
        unpacked->GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
    if (!attribute) return "it has no attribute " + name;
    if (!TakeAttribute(*attribute, unpacked->num_points(), normalized.at(name),
                       &mesh->attributes[name]))
      return "its attribute " + name + " cannot be read";
  }
  return "";
} catch (const std::exception& error) {
  return error.what();
}

}  // namespace keypose
