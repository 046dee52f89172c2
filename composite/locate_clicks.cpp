#include "composite/locate_clicks.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/io/files.h"

namespace keypose::composite {
namespace {

using nlohmann::json;

/// One click's fields; messages name it.
class ClickReader {
 public:
  ClickReader(const json& click, std::string where, const Mesh& mesh)
      : click_(click), where_(std::move(where)), mesh_(mesh) {
    if (!click.is_object()) Fail("is not an object");
  }

  [[noreturn]] void Fail(const std::string& what) const { throw InputError(where_ + " " + what); }

  Eigen::Vector2d Pixel(int width, int height) const {
    const std::vector<double> pixel = Numbers("pixel", 2);
    if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] > width || pixel[1] > height)
      Fail(fmt::format("has pixel [{:g}, {:g}], but the picture has {} x {} pixels", pixel[0],
                       pixel[1], width, height));
    return {pixel[0], pixel[1]};
  }

  SurfacePoint Point() const {
    if (click_.contains("vertex") == click_.contains("face"))
      Fail("needs either a 'vertex', or a 'face' and 'barycentric'");
    SurfacePoint point;
    if (click_.contains("vertex")) {
      point.vertices.setConstant(Index("vertex", mesh_.vertex_count(), "vertices"));
      return point;
    }
    const int face = Index("face", mesh_.face_count(), "faces");
    const std::vector<double> weights = Numbers("barycentric", 3);
    const double sum = weights[0] + weights[1] + weights[2];
    if (weights[0] < -0.01 || weights[1] < -0.01 || weights[2] < -0.01 || sum < 0.9 || sum > 1.1)
      Fail("has 'barycentric' numbers that are not three shares with the sum 1");
    point.vertices = mesh_.faces.row(face).transpose();
    point.weights = Eigen::Vector3d(weights[0], weights[1], weights[2]) / sum;
    return point;
  }

  int Frame() const {
    if (!click_.contains("frame")) return -1;
    if (!click_["frame"].is_number_integer() || click_["frame"].get<int>() < 0)
      Fail("has a 'frame' that is not a number from 0");
    return click_["frame"].get<int>();
  }

 private:
  std::vector<double> Numbers(const char* name, std::size_t count) const {
    const json& list = click_.contains(name) ? click_[name] : json();
    std::vector<double> numbers;
    if (list.is_array() && list.size() == count)
      for (const json& number : list)
        if (number.is_number() && std::isfinite(number.get<double>())) numbers.push_back(number);
    if (numbers.size() != count) Fail(fmt::format("needs '{}': a list of {} numbers", name, count));
    return numbers;
  }
  int Index(const char* name, int count, const char* things) const {
    const json& value = click_[name];
    if (!value.is_number_integer())
      Fail(fmt::format("has a '{}' that is not a whole number", name));
    const auto index = value.get<std::int64_t>();
    if (index < 0 || index >= count)
      Fail(fmt::format("has {} {}, but the mesh has {} {}, counted from 0", name, index, count,
                       things));
    return static_cast<int>(index);
  }

  const json& click_;
  std::string where_;
  const Mesh& mesh_;
};

}  // namespace

std::vector<FrameClick> ReadClicks(const std::filesystem::path& path, const Mesh& mesh, int width,
                                   int height) {
  const std::string text = ReadFile(path), name = PrintableName(path);
  RequireShallowJson(text, name);
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& fault) {
    throw InputError(name + " is not JSON: " + JsonFault(fault));
  }
  if (!root.is_object() || !root.contains("clicks") || !root["clicks"].is_array())
    throw InputError(name + " has no list 'clicks'; docs/file-formats.md shows the format");
  std::vector<FrameClick> clicks;
  for (const json& entry : root["clicks"]) {
    std::string title = std::to_string(clicks.size() + 1);
    if (entry.is_object() && entry.contains("name") && entry["name"].is_string())
      title = "'" + entry["name"].get<std::string>() + "'";
    const ClickReader reader(entry, name + ": click " + title, mesh);
    clicks.push_back(
        {reader.Frame(), {"click " + title, reader.Pixel(width, height), reader.Point()}});
  }
  if (clicks.empty()) throw InputError(name + " has no clicks");
  return clicks;
}

}  // namespace keypose::composite
