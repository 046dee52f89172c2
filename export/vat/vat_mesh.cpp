#include "export/vat/vat_mesh.h"

#include <tiny_gltf.h>

#include <cstring>
#include <sstream>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class MeshBuilder {
 public:
  MeshBuilder() {
    model_.asset.version = "2.0";
    model_.asset.generator = "Keypose";
    model_.buffers.resize(1);
  }

  void AddMesh(const std::string& name, const tinygltf::Primitive& primitive) {
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
    tinygltf::Node node;
    node.name = name;
    node.mesh = 0;
    model_.nodes.push_back(node);
    tinygltf::Scene scene;
    scene.nodes.push_back(0);
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
  }

  void AddMaterial(const EncodedImage* texture) {
    tinygltf::Material material;
    material.name = "clay";
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.9;
    if (texture) {
      tinygltf::Image image;
      image.name = texture->name;
      image.mimeType = texture->mime_type;
      image.bufferView = AddView(texture->bytes.data(), texture->bytes.size(), 0);
      model_.images.push_back(image);
      model_.textures.emplace_back();
      model_.textures[0].source = 0;
      material.pbrMetallicRoughness.baseColorTexture.index = 0;
    }
    model_.materials.push_back(material);
  }

  int AddAttribute(const FloatRows& rows, int type, bool with_bounds) {
    tinygltf::Accessor accessor;
    accessor.bufferView =
        AddView(rows.data(), sizeof(float) * rows.size(), TINYGLTF_TARGET_ARRAY_BUFFER);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.count = static_cast<std::size_t>(rows.rows());
    accessor.type = type;
    for (Eigen::Index c = 0; with_bounds && c < rows.cols(); ++c) {
      accessor.minValues.push_back(rows.col(c).minCoeff());
      accessor.maxValues.push_back(rows.col(c).maxCoeff());
    }
    return Add(accessor);
  }

  int AddIndices(const FacesX3& faces) {
    tinygltf::Accessor accessor;
    accessor.bufferView =
        AddView(faces.data(), sizeof(int) * faces.size(), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.count = static_cast<std::size_t>(faces.size());
    accessor.type = TINYGLTF_TYPE_SCALAR;
    return Add(accessor);
  }

  std::string Bytes() {
    std::ostringstream stream;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, false, true))
      throw ToolError("export: tinygltf could not write the mesh of the vertex animation texture");
    return std::move(stream).str();
  }

 private:
  int Add(const tinygltf::Accessor& accessor) {
    model_.accessors.push_back(accessor);
    return SizeOf(model_.accessors) - 1;
  }

  int AddView(const void* data, std::size_t size, int target) {
    auto& bytes = model_.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 * 4);  // accessors start at multiples of their components
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = size;
    view.target = target;
    bytes.resize(bytes.size() + size);
    std::memcpy(bytes.data() + view.byteOffset, data, size);
    model_.bufferViews.push_back(view);
    return SizeOf(model_.bufferViews) - 1;
  }

  tinygltf::Model model_;
};

/// v points downwards in glTF. Without texture coordinates all are 0: a mesh may not have a second
/// set without the first.
FloatRows ColorUvs(const AnimatedMesh& mesh) {
  if (mesh.uvs.rows() == 0) return FloatRows::Zero(std::ssize(mesh.source_vertex), 2);
  FloatRows uvs = mesh.uvs.cast<float>();
  uvs.col(1) = 1.0f - uvs.col(1).array();
  return uvs;
}

FloatRows TexelUvs(const VatLayout& layout) {
  FloatRows uvs(layout.vertices, 2);
  for (int v = 0; v < layout.vertices; ++v) {
    const int column = v % layout.columns, row = v / layout.columns;
    uvs.row(v) << (static_cast<float>(column) + 0.5f) / static_cast<float>(layout.columns),
        (static_cast<float>(row) + 0.5f) / static_cast<float>(layout.rows_per_frame);
  }
  return uvs;
}

}  // namespace

std::string MakeVatMesh(const Scene& scene, const VatLayout& layout, int frame) {
  const AnimatedMesh& mesh = scene.split;
  if (!scene.textures.empty() && mesh.uvs.rows() == 0) {
    throw InputError("export: the texture " + scene.textures[0].name +
                     " cannot be used, since the first frame has no texture coordinates; unwrap "
                     "the template before it is registered");
  }
  MeshBuilder builder;
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  const FloatRows points = WithYUp(mesh.points[frame], scene.z_up).cast<float>(),
                  normals = WithYUp(mesh.normals[frame], scene.z_up).cast<float>();
  primitive.attributes["POSITION"] = builder.AddAttribute(points, TINYGLTF_TYPE_VEC3, true);
  primitive.attributes["NORMAL"] = builder.AddAttribute(normals, TINYGLTF_TYPE_VEC3, false);
  primitive.attributes["TEXCOORD_0"] =
      builder.AddAttribute(ColorUvs(mesh), TINYGLTF_TYPE_VEC2, false);
  primitive.attributes["TEXCOORD_1"] =
      builder.AddAttribute(TexelUvs(layout), TINYGLTF_TYPE_VEC2, false);
  primitive.indices = builder.AddIndices(mesh.faces);
  builder.AddMaterial(scene.textures.empty() ? nullptr : &scene.textures[0]);
  builder.AddMesh(scene.name, primitive);
  return builder.Bytes();
}

}  // namespace keypose::exporting
