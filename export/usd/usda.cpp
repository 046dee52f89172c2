#include "export/usd/usda.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "export/usd/usda_text.h"

namespace keypose::exporting {
namespace {

/// The attributes of one keyframe, as text.
struct Sample {
  std::string time, points, normals, extent;
  double error = 0;  ///< largest distance between a written and a given point
};

/// Frames at the scene's rate. Keyframes lie at whole frames, or a thousandth before one: the
/// rounding only removes the noise of seconds.
double TimeCode(const Keyframe& keyframe, double fps) {
  return std::round(keyframe.seconds * fps * 1e6) / 1e6;
}

/// Normals of the vertices, not split. All copies of a vertex have the same normal; vertices
/// without a face get one that points up.
PointsX3 VertexNormalsOf(const Scene& scene, int frame) {
  const AnimatedMesh& split = scene.split;
  PointsX3 normals(scene.frames[frame].vertex_count(), 3);
  normals.rowwise() = Eigen::RowVector3d(0, scene.z_up ? 0 : 1, scene.z_up ? 1 : 0);
  for (int i = 0; i < SizeOf(split.source_vertex); ++i)
    normals.row(split.source_vertex[i]) = split.normals[frame].row(i);
  return WithYUp(normals, scene.z_up);
}

std::string ExtentOf(const PointsX3& points) {
  PointsX3 corners(2, 3);
  corners << points.colwise().minCoeff(), points.colwise().maxCoeff();
  return TupleArray(corners);
}

Sample MakeSample(const Scene& scene, const Keyframe& keyframe) {
  const PointsX3 points = WithYUp(scene.frames[keyframe.frame].points, scene.z_up);
  Sample sample;
  sample.time = ShortNumber(TimeCode(keyframe, scene.playback.fps));
  sample.points = TupleArray(points);
  sample.normals = TupleArray(VertexNormalsOf(scene, keyframe.frame));
  sample.extent = ExtentOf(points);
  const PointsX3 difference = points.cast<float>().cast<double>() - points;
  sample.error = difference.rowwise().norm().maxCoeff();
  return sample;
}

std::vector<Sample> MakeSamples(const Scene& scene, const std::vector<Keyframe>& keyframes,
                                Progress* progress) {
  std::vector<Sample> samples(keyframes.size());
  constexpr std::int64_t kAtOnce = 16;  // progress is reported, and cancel noticed, in between
  for (std::int64_t begin = 0; begin < std::ssize(samples); begin += kAtOnce) {
    ReportProgress(progress, 0.8 * static_cast<double>(begin) / static_cast<double>(samples.size()),
                   "writing the USD file");
    ParallelFor(std::min(kAtOnce, std::ssize(samples) - begin), [&](std::int64_t i) {
      samples[begin + i] = MakeSample(scene, keyframes[begin + i]);
    });
  }
  return samples;
}

/// Appends lines with the indentation of the open blocks.
class UsdaWriter {
 public:
  void Line(const std::string& text) { text_ += std::string(4 * depth_, ' ') + text + '\n'; }
  void EmptyLine() { text_ += '\n'; }
  void Open(const std::string& text) {
    Line(text);
    ++depth_;
  }
  void Close(const std::string& text = "}") {
    --depth_;
    Line(text);
  }
  /// A prim without metadata, and the start of its block.
  void OpenPrim(const std::string& text) {
    Line(text);
    Open("{");
  }
  /// An attribute with its value and one line of metadata.
  void Attribute(const std::string& text, const std::string& interpolation) {
    Open(text + " (");
    Line("interpolation = \"" + interpolation + '"');
    Close(")");
  }
  std::string Text() && { return std::move(text_); }

 private:
  std::string text_;
  int depth_ = 0;
};

void WriteHeader(UsdaWriter& out, const Scene& scene, const std::vector<Sample>& samples) {
  out.Line("#usda 1.0");
  out.Open("(");
  out.Line("defaultPrim = \"" + PrimName(scene.name) + '"');
  const std::string fps = ShortNumber(scene.playback.fps);
  out.Line("endTimeCode = " + samples.back().time);
  out.Line("framesPerSecond = " + fps);
  out.Line("metersPerUnit = 1");
  out.Line("startTimeCode = 0");
  out.Line("timeCodesPerSecond = " + fps);
  out.Line("upAxis = \"Y\"");
  out.Close(")");
  out.EmptyLine();
}

/// @param name  with the type: "point3f[] points"
/// @param interpolation  "": none is written
void WriteSamples(UsdaWriter& out, const std::string& name, const std::string& interpolation,
                  const std::vector<Sample>& samples, std::string Sample::*text) {
  const std::string value = name + " = " + samples[0].*text;
  if (interpolation.empty()) {
    out.Line(value);
  } else {
    out.Attribute(value, interpolation);
  }
  if (samples.size() < 2) return;
  out.Open(name + ".timeSamples = {");
  for (const Sample& sample : samples) out.Line(sample.time + ": " + sample.*text + ',');
  out.Close();
}

void WriteMesh(UsdaWriter& out, const Scene& scene, const std::vector<Sample>& samples) {
  const Mesh& mesh = scene.frames[0];
  out.Open("def Mesh \"mesh\" (");
  out.Line("prepend apiSchemas = [\"MaterialBindingAPI\"]");
  out.Close(")");
  out.Open("{");
  out.Line("uniform bool doubleSided = 1");
  WriteSamples(out, "float3[] extent", "", samples, &Sample::extent);
  out.Line("int[] faceVertexCounts = " + NumberArray(scene.net.sizes));
  out.Line("int[] faceVertexIndices = " + NumberArray(scene.net.vertices));
  out.Line("rel material:binding = </" + PrimName(scene.name) + "/materials/clay>");
  WriteSamples(out, "normal3f[] normals", "vertex", samples, &Sample::normals);
  WriteSamples(out, "point3f[] points", "", samples, &Sample::points);
  if (mesh.has_uvs()) {
    out.Attribute("texCoord2f[] primvars:st = " + TupleArray(mesh.uvs), "faceVarying");
    out.Line("int[] primvars:st:indices = " + NumberArray(scene.net.uvs));
  }
  out.Line("uniform token subdivisionScheme = \"none\"");
  out.Close();
}

void WriteTextureShaders(UsdaWriter& out, const std::string& material, const std::string& file) {
  out.OpenPrim("def Shader \"texture\"");
  out.Line("uniform token info:id = \"UsdUVTexture\"");
  out.Line("asset inputs:file = @" + file + '@');
  out.Line("token inputs:sourceColorSpace = \"sRGB\"");
  out.Line("float2 inputs:st.connect = <" + material + "/st.outputs:result>");
  out.Line("token inputs:wrapS = \"clamp\"");
  out.Line("token inputs:wrapT = \"clamp\"");
  out.Line("float3 outputs:rgb");
  out.Close();
  out.OpenPrim("def Shader \"st\"");
  out.Line("uniform token info:id = \"UsdPrimvarReader_float2\"");
  out.Line("string inputs:varname = \"st\"");
  out.Line("float2 outputs:result");
  out.Close();
}

void WriteMaterial(UsdaWriter& out, const Scene& scene) {
  const std::string material = '/' + PrimName(scene.name) + "/materials/clay";
  const bool textured = scene.frames[0].has_uvs() && !scene.textures.empty();
  out.OpenPrim("def Scope \"materials\"");
  out.OpenPrim("def Material \"clay\"");
  out.Line("token outputs:surface.connect = <" + material + "/surface.outputs:surface>");
  out.OpenPrim("def Shader \"surface\"");
  out.Line("uniform token info:id = \"UsdPreviewSurface\"");
  out.Line(textured ? "color3f inputs:diffuseColor.connect = <" + material + "/texture.outputs:rgb>"
                    : "color3f inputs:diffuseColor = (0.8, 0.8, 0.8)");
  out.Line("float inputs:metallic = 0");
  out.Line("float inputs:roughness = 0.9");
  out.Line("token outputs:surface");
  out.Close();
  if (textured) WriteTextureShaders(out, material, "textures/" + FirstTextureFile(scene));
  out.Close();
  out.Close();
}

}  // namespace

std::string PrimName(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool digit = c >= '0' && c <= '9';
    if (out.empty() && digit) out = '_';
    out += letter || digit ? c : '_';
  }
  return out.empty() ? "_" : out;
}

FormatFiles MakeUsda(const Scene& scene, Progress* progress) {
  const std::vector<Sample> samples = MakeSamples(scene, SceneKeyframes(scene), progress);
  UsdaWriter out;
  WriteHeader(out, scene, samples);
  out.Open("def Xform \"" + PrimName(scene.name) + "\" (");
  out.Line("kind = \"component\"");
  out.Close(")");
  out.Open("{");
  WriteMesh(out, scene, samples);
  out.EmptyLine();
  WriteMaterial(out, scene);
  out.Close();
  FormatFiles made;
  made.files = {{scene.name + ".usda", std::move(out).Text()}};
  double error = 0;
  for (const Sample& sample : samples) error = std::max(error, sample.error);
  made.error_over_diagonal = error / SceneDiagonal(scene);
  made.measured["time_samples"] = SizeOf(samples);
  return made;
}

}  // namespace keypose::exporting
