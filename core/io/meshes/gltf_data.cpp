#include "core/io/meshes/gltf_data.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/io/meshes/gltf_draco.h"

namespace keypose {
namespace {

constexpr const char* kBeyond = "it is damaged (data that it does not have)";
constexpr std::size_t kMostCount = 150'000'000;  // corners of 50 million faces

template <class T>
void Convert(std::string_view bytes, std::size_t stride, bool normalized, GltfRows* rows) {
  const bool scaled = normalized && std::numeric_limits<T>::is_integer;
  const double scale = scaled ? 1.0 / static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  const auto columns = static_cast<std::size_t>(rows->cols());
  double* to = rows->data();
  for (Eigen::Index i = 0; i < rows->rows(); ++i) {
    const char* from = bytes.data() + static_cast<std::size_t>(i) * stride;
    for (std::size_t c = 0; c < columns; ++c, from += sizeof(T)) {
      T value;
      std::memcpy(&value, from, sizeof(T));
      *to++ = scale * static_cast<double>(value);
    }
  }
  // Of signed ones, both the least and the one above it are -1.
  if (scaled && std::numeric_limits<T>::is_signed) *rows = rows->cwiseMax(-1.0);
}

std::size_t BytesOf(int component) {
  switch (component) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5124:
    case 5125:
    case 5126:
      return 4;
    case 5130:
      return 8;
    default:
      return 0;
  }
}

void ConvertAs(int component, std::string_view bytes, std::size_t stride, bool normalized,
               GltfRows* rows) {
  switch (component) {
    case 5120:
      return Convert<std::int8_t>(bytes, stride, normalized, rows);
    case 5121:
      return Convert<std::uint8_t>(bytes, stride, normalized, rows);
    case 5122:
      return Convert<std::int16_t>(bytes, stride, normalized, rows);
    case 5123:
      return Convert<std::uint16_t>(bytes, stride, normalized, rows);
    case 5124:
      return Convert<std::int32_t>(bytes, stride, normalized, rows);
    case 5125:
      return Convert<std::uint32_t>(bytes, stride, normalized, rows);
    case 5130:
      return Convert<double>(bytes, stride, normalized, rows);
    default:
      return Convert<float>(bytes, stride, normalized, rows);
  }
}

/// Applies a filter of meshopt in place. @return whether it is known and fits the stride
bool Filter(const std::string& name, std::string* bytes, std::size_t count, std::size_t stride) {
  if (name == "NONE") return true;
  if (name == "OCTAHEDRAL" && (stride == 4 || stride == 8))
    meshopt_decodeFilterOct(bytes->data(), count, stride);
  else if (name == "QUATERNION" && stride == 8)
    meshopt_decodeFilterQuat(bytes->data(), count, stride);
  else if (name == "EXPONENTIAL" && stride % 4 == 0)
    meshopt_decodeFilterExp(bytes->data(), count, stride);
  else
    return false;
  return true;
}

}  // namespace

std::string_view GltfData::Slice(int buffer, std::size_t offset, std::size_t length) const {
  const std::string_view bytes = file_.At(file_.buffers, buffer, "part of its data").bytes;
  if (offset > bytes.size() || length > bytes.size() - offset) file_.Refuse(kBeyond);
  return bytes.substr(offset, length);
}

std::string_view GltfData::Bytes(int view_index) {
  const GltfView& view = file_.At(file_.views, view_index, "part of its data");
  if (!view.packed) return Slice(view.buffer, view.offset, view.length);
  const auto found = unpacked_.find(view_index);
  if (found != unpacked_.end()) return found->second;
  return unpacked_.emplace(view_index, Unpack(*view.packed, view.length)).first->second;
}

std::string GltfData::Unpack(const GltfPacked& packed, std::size_t length) const {
  const std::string_view bytes = Slice(packed.buffer, packed.offset, packed.length);
  const bool corners = packed.mode == "TRIANGLES" || packed.mode == "INDICES";
  const bool fits = corners ? packed.stride == 2 || packed.stride == 4
                            : packed.stride > 0 && packed.stride <= 256 && packed.stride % 4 == 0;
  // No stream is shorter than a 300th of what it holds.
  constexpr std::size_t kLargestRatio = 300, kTail = 1000;
  if (!fits || packed.count > kMostCount || packed.count * packed.stride != length ||
      length > kLargestRatio * bytes.size() + kTail)
    file_.Refuse("it is damaged (its meshopt data do not fit their description)");
  if (packed.mode == "TRIANGLES" && packed.count % 3 != 0)
    file_.Refuse("it is damaged (its meshopt data do not fit their description)");
  std::string out(length, '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
  int fault = -1;
  if (packed.mode == "ATTRIBUTES")
    fault = meshopt_decodeVertexBuffer(out.data(), packed.count, packed.stride, from, bytes.size());
  if (packed.mode == "TRIANGLES")
    fault = meshopt_decodeIndexBuffer(out.data(), packed.count, packed.stride, from, bytes.size());
  if (packed.mode == "INDICES")
    fault =
        meshopt_decodeIndexSequence(out.data(), packed.count, packed.stride, from, bytes.size());
  if (fault != 0 || (!corners && !Filter(packed.filter, &out, packed.count, packed.stride)))
    file_.Refuse(fmt::format(
        "its data are packed by meshopt (EXT_meshopt_compression, mode {}, filter {}) in a way "
        "that is not read, or damaged; export it without compression",
        packed.mode, packed.filter));
  return out;
}

GltfRows GltfData::Stored(int view_index, std::size_t offset, std::size_t count, int columns,
                          int component, bool normalized) {
  const std::size_t bytes_each = BytesOf(component), size = bytes_each * columns;
  if (columns < 1 || bytes_each == 0)
    file_.Refuse(fmt::format("it has numbers of an unknown kind (componentType {})", component));
  GltfRows rows(static_cast<Eigen::Index>(0), columns);
  if (count == 0) return rows;
  const std::string_view bytes = Bytes(view_index);
  const std::size_t given = file_.views[static_cast<std::size_t>(view_index)].stride,
                    stride = given > 0 ? given : size;
  if (offset > bytes.size() || size > bytes.size() - offset ||
      count - 1 > (bytes.size() - offset - size) / stride)
    file_.Refuse(kBeyond);
  if (count > kMostCount) file_.Refuse("it has too many vertices");
  rows.resize(static_cast<Eigen::Index>(count), columns);  // no more than the file has
  ConvertAs(component, bytes.substr(offset), stride, normalized, &rows);
  return rows;
}

void GltfData::PutSparse(const GltfAccessor& accessor, GltfRows* rows) {
  const GltfSparse& sparse = *accessor.sparse;
  const GltfRows places = Stored(sparse.index_view, sparse.index_offset, sparse.count, 1,
                                 sparse.index_component, false),
                 values = Stored(sparse.value_view, sparse.value_offset, sparse.count,
                                 accessor.columns, accessor.component, accessor.normalized);
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const double place = places(i, 0);
    if (!(place >= 0 && place < static_cast<double>(rows->rows())))
      file_.Refuse("it is damaged (a sparse entry beyond its list)");
    rows->row(static_cast<Eigen::Index>(place)) = values.row(i);
  }
}

GltfRows GltfData::Numbers(int index) {
  const GltfAccessor& accessor = file_.At(file_.accessors, index, "list of numbers");
  GltfRows rows;
  if (accessor.view >= 0) {
    rows = Stored(accessor.view, accessor.offset, accessor.count, accessor.columns,
                  accessor.component, accessor.normalized);
  } else {
    // Zeros. As many as other lists of the file can have.
    constexpr std::size_t kMostPerByte = 16;
    if (accessor.columns < 1 || accessor.count > kMostCount ||
        accessor.count > kMostPerByte * file_.bytes())
      file_.Refuse(kBeyond);
    rows = GltfRows::Zero(static_cast<Eigen::Index>(accessor.count), accessor.columns);
  }
  if (accessor.sparse) PutSparse(accessor, &rows);
  return rows;
}

bool GltfData::IsDraco(const GltfPrimitive& part) const {
  if (part.draco_view < 0) return false;
  const auto position = part.attributes.find("POSITION");
  if (position == part.attributes.end()) return true;
  return file_.At(file_.accessors, position->second, "list of numbers").view < 0;
}

GltfData::Unpacked GltfData::Draco(const GltfPrimitive& part) {
  std::map<std::string, bool> normalized;
  for (const auto& [name, id] : part.draco_attributes) {
    const auto accessor = part.attributes.find(name);
    normalized[name] = accessor != part.attributes.end() &&
                       file_.At(file_.accessors, accessor->second, "list of numbers").normalized;
  }
  DracoMesh mesh;
  const std::string fault =
      UnpackDraco(Bytes(part.draco_view), part.draco_attributes, normalized, &mesh);
  if (!fault.empty())
    file_.Refuse(fmt::format(
        "its data are packed by Draco (KHR_draco_mesh_compression) in a way that is not read, or "
        "damaged ({}); export it without compression",
        fault));
  Unpacked unpacked;
  unpacked.corners = std::move(mesh.corners);
  for (auto& [name, rows] : mesh.attributes) unpacked.attributes[name] = std::move(rows);
  return unpacked;
}

}  // namespace keypose
