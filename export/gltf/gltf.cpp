#include "export/gltf/gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <sstream>

#include "core/errors.h"
#include "core/size_of.h"

namespace keypose::exporting {
namespace {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr double kLargestGlb = std::numeric_limits<std::uint32_t>::max();

class GlbBuilder {
 public:
  GlbBuilder(const AnimatedMesh& mesh, const Clip& clip, const GlbOptions& options)
      : mesh_(mesh), clip_(clip), options_(options) {
    for (int i = 1; i < clip.frame_count(); ++i)
      if (clip.picture[i] == i) targets_.push_back(i);
    model_.asset.version = "2.0";
    model_.asset.generator = "Keypose";
    model_.buffers.resize(1);
  }

  void AddMesh(const std::vector<std::string>& frame_names) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    const FloatRows base_points = InGltf(mesh_.points[0]), base_normals = InGltf(mesh_.normals[0]);
    primitive.attributes["POSITION"] = AddAttribute(base_points, TINYGLTF_TYPE_VEC3, true);
    primitive.attributes["NORMAL"] = AddAttribute(base_normals, TINYGLTF_TYPE_VEC3, false);
    if (mesh_.uvs.rows() > 0) {
      FloatRows uvs = mesh_.uvs.cast<float>();
      uvs.col(1) = 1.0f - uvs.col(1).array();  // v points downwards in glTF
      primitive.attributes["TEXCOORD_0"] = AddAttribute(uvs, TINYGLTF_TYPE_VEC2, false);
    }
    primitive.indices = AddIndices();
    tinygltf::Mesh out;
    tinygltf::Value::Array target_names;
    for (const int i : targets_) {
      primitive.targets.push_back({{"POSITION", AddAttribute(InGltf(mesh_.points[i]) - base_points,
                                                             TINYGLTF_TYPE_VEC3, true)},
                                   {"NORMAL", AddAttribute(InGltf(mesh_.normals[i]) - base_normals,
                                                           TINYGLTF_TYPE_VEC3, false)}});
      target_names.emplace_back(frame_names[i]);
    }
    out.name = options_.name;
    if (!target_names.empty()) {
      out.weights.assign(target_names.size(), 0.0);
      out.extras =
          tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(target_names)}});
    }
    out.primitives.push_back(primitive);
    model_.meshes.push_back(out);
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
    model_.materials.push_back(material);
  }

  void AddScene() {
    tinygltf::Node node;
    node.name = options_.name;
    node.mesh = 0;
    model_.nodes.push_back(node);
    tinygltf::Scene scene;
    scene.nodes.push_back(0);
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
  }

  void AddAnimation() {
    if (targets_.empty()) return;
    const auto moments = PlaybackMoments(clip_, options_.playback);
    std::vector<Keyframe> keyframes = StepKeyframes(moments, clip_);
    const bool steps = !keyframes.empty();
    if (!steps) keyframes = LinearKeyframes(moments, clip_, options_.playback.fps);
    tinygltf::Animation animation;
    animation.name = options_.name;
    tinygltf::AnimationSampler sampler;
    sampler.interpolation = steps ? "STEP" : "LINEAR";
    AddSamples(keyframes, sampler);
    animation.samplers.push_back(sampler);
    tinygltf::AnimationChannel channel;
    channel.sampler = 0;
    channel.target_node = 0;
    channel.target_path = "weights";
    animation.channels.push_back(channel);
    model_.animations.push_back(animation);
  }

  std::string Bytes() {
    if (static_cast<double>(model_.buffers[0].data.size()) > kLargestGlb - (1 << 20)) {
      throw InputError("export: " + std::to_string(targets_.size() + 1) + " pictures of " +
                       std::to_string(mesh_.source_vertex.size()) +
                       " vertices need more than the 4 GiB that a GLB can hold; use fewer "
                       "in-betweens, or the OBJ or PLY sequence");
    }
    tinygltf::TinyGLTF writer;
    std::ostringstream stream;
    if (!writer.WriteGltfSceneToStream(&model_, stream, false, true))
      throw SolverError("export: tinygltf could not write the GLB");
    return std::move(stream).str();
  }

 private:
  void AddTextures(const std::vector<EncodedImage>& images) {
    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model_.samplers.push_back(sampler);
    for (std::size_t i = 0; i < images.size(); ++i) {
      tinygltf::Image image;
      image.name = images[i].name;
      image.mimeType = images[i].mime_type;
      image.bufferView = AddView(images[i].bytes.data(), images[i].bytes.size(), 0);
      model_.images.push_back(image);
      tinygltf::Texture texture;
      texture.sampler = 0;
      texture.source = static_cast<int>(i);
      model_.textures.push_back(texture);
    }
  }

  /// Stored in `extras`: viewers that do not know them show the base colour.
  static tinygltf::Value BlendExtras(const GlbTextures& textures) {
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

  /// At a keyframe, the weight of its picture's target is 1 and all others are 0. The first picture
  /// is the mesh itself.
  void AddSamples(const std::vector<Keyframe>& keyframes, tinygltf::AnimationSampler& sampler) {
    const auto count = std::ssize(targets_);
    FloatRows times(keyframes.size(), 1),
        weights = FloatRows::Zero(std::ssize(keyframes) * count, 1);
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
      times(i, 0) = static_cast<float>(keyframes[i].seconds);
      const int picture = clip_.picture[keyframes[i].frame];
      const auto target =
          std::lower_bound(targets_.begin(), targets_.end(), picture) - targets_.begin();
      if (picture > 0) weights(static_cast<Eigen::Index>(i) * count + target, 0) = 1;
    }
    sampler.input = AddScalars(times, true);
    sampler.output = AddScalars(weights, false);
  }

  // The only place that converts the axes.
  FloatRows InGltf(const PointsX3& rows) const {
    FloatRows out = rows.cast<float>();
    if (!options_.z_up) return out;
    out.col(1) = rows.col(2).cast<float>();
    out.col(2) = -rows.col(1).cast<float>();
    return out;
  }

  int AddView(const void* data, std::size_t size, int target) {
    auto& bytes = model_.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 *
                 4);  // accessors must start at multiples of their component's size
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
    model_.accessors.push_back(accessor);
    return SizeOf(model_.accessors) - 1;
  }
  int AddAttribute(const FloatRows& rows, int type, bool with_bounds) {
    return AddAccessor(rows, type, TINYGLTF_TARGET_ARRAY_BUFFER, with_bounds);
  }
  int AddScalars(const FloatRows& rows, bool with_bounds) {
    return AddAccessor(rows, TINYGLTF_TYPE_SCALAR, 0, with_bounds);
  }

  int AddIndices() {
    tinygltf::Accessor accessor;
    accessor.bufferView = AddView(mesh_.faces.data(), sizeof(int) * mesh_.faces.size(),
                                  TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.count = mesh_.faces.size();
    accessor.type = TINYGLTF_TYPE_SCALAR;
    model_.accessors.push_back(accessor);
    return SizeOf(model_.accessors) - 1;
  }

  const AnimatedMesh& mesh_;
  const Clip& clip_;
  const GlbOptions& options_;
  std::vector<int> targets_;  ///< all pictures but the first, ascending
  tinygltf::Model model_;
};

}  // namespace

std::string MakeGlb(const AnimatedMesh& mesh, const Clip& clip,
                    const std::vector<std::string>& frame_names, const GlbTextures& textures,
                    const GlbOptions& options) {
  if (!textures.images.empty() && mesh.uvs.rows() == 0) {
    throw InputError("export: the texture " + textures.images[0].name +
                     " cannot be used, since the first frame has no texture coordinates; unwrap "
                     "the template before it is registered");
  }
  GlbBuilder builder(mesh, clip, options);
  builder.AddMesh(frame_names);
  builder.AddMaterial(textures);
  builder.AddScene();
  builder.AddAnimation();
  return builder.Bytes();
}

}  // namespace keypose::exporting
