#include "export/gltf/glb_builder.h"

#include <tiny_gltf.h>

#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <sstream>
#include <utility>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

constexpr double kLargestGlb = std::numeric_limits<std::uint32_t>::max();

/// Stored in `extras`: viewers that do not know them show the base colour.
tinygltf::Value BlendExtras(const GlbTextures& textures) {
  tinygltf::Value::Array indices, poses, moments;
  for (std::size_t i = 0; i < textures.images.size(); ++i) {
    indices.emplace_back(static_cast<int>(i));
    poses.emplace_back(textures.poses[i]);
  }
  for (const TextureMoment& moment : textures.moments) {
    tinygltf::Value::Array weights;
    for (const double weight : moment.weights) weights.emplace_back(weight);
    moments.emplace_back(tinygltf::Value::Object{{"seconds", tinygltf::Value(moment.seconds)},
                                                 {"weights", tinygltf::Value(weights)}});
  }
  tinygltf::Value::Object blend{{"textures", tinygltf::Value(indices)},
                                {"poses", tinygltf::Value(poses)},
                                {"moments", tinygltf::Value(moments)}};
  return tinygltf::Value(tinygltf::Value::Object{{"keypose", tinygltf::Value(blend)}});
}

/// The largest single-precision time that is not after `seconds`: a player that asks at n / fps
/// then finds the picture of that frame, not the one before.
float KeyTime(double seconds) {
  const auto nearest = static_cast<float>(seconds);
  return nearest > seconds ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
                           : nearest;
}

}  // namespace

FloatRows GltfRows(const PointsX3& rows, bool z_up) {
  FloatRows out = rows.cast<float>();
  if (!z_up) return out;
  out.col(1) = rows.col(2).cast<float>();
  out.col(2) = -rows.col(1).cast<float>();
  return out;
}

struct GlbBuilder::Parts {
  const AnimatedMesh& split;
  std::string name;
  tinygltf::Model model;
  tinygltf::Primitive primitive;
  tinygltf::Value::Array target_names;

  int AddView(const void* data, std::size_t size, int target) {
    auto& bytes = model.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 *
                 4);  // accessors must start at multiples of their component's size
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = size;
    view.target = target;
    bytes.resize(bytes.size() + size);
    std::memcpy(bytes.data() + view.byteOffset, data, size);
    model.bufferViews.push_back(view);
    return SizeOf(model.bufferViews) - 1;
  }

  int AddAccessor(const FloatRows& rows, int type, int view_target, bool with_bounds) {
    tinygltf::Accessor accessor;
    accessor.bufferView = AddView(rows.data(), sizeof(float) * rows.size(), view_target);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.count = rows.rows();
    accessor.type = type;
    if (with_bounds) {
      for (Eigen::Index c = 0; c < rows.cols(); ++c) {
        accessor.minValues.push_back(rows.col(c).minCoeff());
        accessor.maxValues.push_back(rows.col(c).maxCoeff());
      }
    }
    model.accessors.push_back(accessor);
    return SizeOf(model.accessors) - 1;
  }
  int AddAttribute(const FloatRows& rows, int type, bool with_bounds) {
    return AddAccessor(rows, type, TINYGLTF_TARGET_ARRAY_BUFFER, with_bounds);
  }
  std::map<std::string, int> AddShape(const GlbShape& shape) {
    const int positions = AddAttribute(shape.positions, TINYGLTF_TYPE_VEC3, true);
    const int normals = AddAttribute(shape.normals, TINYGLTF_TYPE_VEC3, false);
    return {{"POSITION", positions}, {"NORMAL", normals}};
  }

  int AddIndices() {
    tinygltf::Accessor accessor;
    accessor.bufferView = AddView(split.faces.data(), sizeof(int) * split.faces.size(),
                                  TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.count = split.faces.size();
    accessor.type = TINYGLTF_TYPE_SCALAR;
    model.accessors.push_back(accessor);
    return SizeOf(model.accessors) - 1;
  }

  void AddTextures(const std::vector<EncodedImage>& images) {
    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model.samplers.push_back(sampler);
    for (std::size_t i = 0; i < images.size(); ++i) {
      tinygltf::Image image;
      image.name = images[i].name;
      image.mimeType = images[i].mime_type;
      image.bufferView = AddView(images[i].bytes.data(), images[i].bytes.size(), 0);
      model.images.push_back(image);
      tinygltf::Texture texture;
      texture.sampler = 0;
      texture.source = static_cast<int>(i);
      model.textures.push_back(texture);
    }
  }

  void AddMaterial(const GlbTextures& textures) {
    tinygltf::Material material;
    material.name = "clay";
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.9;
    if (!textures.images.empty()) {
      AddTextures(textures.images);
      material.pbrMetallicRoughness.baseColorTexture.index = 0;
      if (textures.images.size() > 1) material.extras = BlendExtras(textures);
    }
    model.materials.push_back(material);
  }

  void AddMesh(const std::vector<double>& first_weights) {
    tinygltf::Mesh mesh;
    mesh.name = name;
    if (!target_names.empty()) {
      mesh.weights = first_weights;
      mesh.extras =
          tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(target_names)}});
    }
    mesh.primitives.push_back(primitive);
    model.meshes.push_back(mesh);
  }

  void AddScene() {
    tinygltf::Node node;
    node.name = name;
    node.mesh = 0;
    model.nodes.push_back(node);
    tinygltf::Scene scene;
    scene.nodes.push_back(0);
    model.scenes.push_back(scene);
    model.defaultScene = 0;
  }

  void AddAnimation(const GlbWeights& track) {
    const auto count = std::ssize(track.seconds);
    FloatRows times(count, 1);
    for (Eigen::Index i = 0; i < count; ++i) times(i, 0) = KeyTime(track.seconds[i]);
    tinygltf::AnimationSampler sampler;
    sampler.interpolation = track.steps ? "STEP" : "LINEAR";
    sampler.input = AddAccessor(times, TINYGLTF_TYPE_SCALAR, 0, true);
    const FloatRows flat = track.weights.reshaped<Eigen::RowMajor>();
    sampler.output = AddAccessor(flat, TINYGLTF_TYPE_SCALAR, 0, false);
    tinygltf::AnimationChannel channel;
    channel.sampler = 0;
    channel.target_node = 0;
    channel.target_path = "weights";
    tinygltf::Animation animation;
    animation.name = name + "_animation";  // readers that make both a node refuse one name for two
    animation.samplers.push_back(sampler);
    animation.channels.push_back(channel);
    model.animations.push_back(animation);
  }

  void RequireThatItFits() const {
    if (static_cast<double>(model.buffers[0].data.size()) <= kLargestGlb - (1 << 20)) return;
    throw InputError("export: " + std::to_string(target_names.size() + 1) + " pictures of " +
                     std::to_string(split.source_vertex.size()) +
                     " vertices need more than the 4 GiB that a GLB can hold; use fewer "
                     "in-betweens, or the OBJ or PLY sequence");
  }
};

GlbBuilder::GlbBuilder(const AnimatedMesh& split, std::string name)
    : parts_(new Parts{split, std::move(name), {}, {}, {}}) {
  parts_->model.asset.version = "2.0";
  parts_->model.asset.generator = "Keypose";
  parts_->model.buffers.resize(1);
  parts_->primitive.mode = TINYGLTF_MODE_TRIANGLES;
  parts_->primitive.material = 0;
}

GlbBuilder::~GlbBuilder() = default;

void GlbBuilder::Base(const GlbShape& shape) {
  parts_->primitive.attributes = parts_->AddShape(shape);
  if (parts_->split.uvs.rows() > 0) {
    FloatRows uvs = parts_->split.uvs.cast<float>();
    uvs.col(1) = 1.0f - uvs.col(1).array();  // v points downwards in glTF
    parts_->primitive.attributes["TEXCOORD_0"] =
        parts_->AddAttribute(uvs, TINYGLTF_TYPE_VEC2, false);
  }
  parts_->primitive.indices = parts_->AddIndices();
}

void GlbBuilder::Target(const std::string& name, const GlbShape& difference) {
  parts_->primitive.targets.push_back(parts_->AddShape(difference));
  parts_->target_names.emplace_back(name);
}

std::string GlbBuilder::Finish(const std::vector<double>& first_weights,
                               const GlbTextures& textures, const GlbWeights& animation) {
  if (!textures.images.empty() && parts_->split.uvs.rows() == 0) {
    throw InputError("export: the texture " + textures.images[0].name +
                     " cannot be used, since the first frame has no texture coordinates; unwrap "
                     "the template before it is registered");
  }
  parts_->AddMesh(first_weights);
  parts_->AddMaterial(textures);
  parts_->AddScene();
  if (!animation.seconds.empty()) parts_->AddAnimation(animation);
  parts_->RequireThatItFits();
  tinygltf::TinyGLTF writer;
  std::ostringstream stream;
  if (!writer.WriteGltfSceneToStream(&parts_->model, stream, false, true))
    throw SolverError("export: tinygltf could not write the GLB");
  return std::move(stream).str();
}

}  // namespace keypose::exporting
