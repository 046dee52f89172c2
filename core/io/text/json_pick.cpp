#include "core/io/text/json_pick.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {

using nlohmann::json;

bool IsInTriangle(const Eigen::Vector3d& barycentric) {
  return barycentric.allFinite() && barycentric.minCoeff() >= -1e-6 &&
         std::abs(barycentric.sum() - 1) <= 1e-6;
}

template <>
json ReadJson(const std::filesystem::path& path) {
  const std::string text = ReadFile(path), name = PrintableName(path);
  RequireShallowJson(text, name);
  try {
    return json::parse(text);
  } catch (const json::exception& fault) {
    throw InputError(name + " is not JSON: " + JsonFault(fault));
  }
}

template <class Json>
JsonPick<Json>::JsonPick(const Json& pick, const std::string& file, const std::string& kind,
                         int number)
    : pick_(pick), file_(file), title_(fmt::format("{} {}", kind, number)) {
  if (!pick.is_object()) Fail("is not an object");
  if (pick.contains("name") && pick["name"].is_string()) title_ = kind + " '" + Name() + "'";
}

template <class Json>
void JsonPick<Json>::Fail(const std::string& what) const {
  throw InputError(fmt::format("{}: {} {}", file_, title_, what));
}

template <class Json>
std::string JsonPick<Json>::Name() const {
  if (!pick_.contains("name") || !pick_["name"].is_string()) Fail("needs a 'name'");
  return pick_["name"].template get<std::string>();
}

template <class Json>
std::vector<double> JsonPick<Json>::Numbers(const char* name, std::size_t count) const {
  std::vector<double> numbers;
  if (pick_.contains(name) && pick_[name].is_array() && pick_[name].size() == count)
    for (const Json& number : pick_[name])
      if (number.is_number() && std::isfinite(number.template get<double>()))
        numbers.push_back(number);
  if (numbers.size() != count) Fail(fmt::format("needs '{}': a list of {} numbers", name, count));
  return numbers;
}

template <class Json>
bool JsonPick<Json>::HasPlace() const {
  return pick_.contains("vertex") || pick_.contains("face");
}

template <class Json>
int JsonPick<Json>::Index(const char* name, int count, const char* things,
                          const std::string& owner) const {
  const Json& value = pick_[name];
  if (!value.is_number_integer()) Fail(fmt::format("has a '{}' that is not a whole number", name));
  const auto index = value.template get<std::int64_t>();
  if (index < 0 || index >= count)
    Fail(
        fmt::format("has {} {}, but the {} has {} {}, counted from 0; it was picked on another "
                    "mesh: pick it again",
                    name, index, owner, count, things));
  return static_cast<int>(index);
}

template <class Json>
SurfacePoint JsonPick<Json>::Point(const Mesh& mesh, const std::string& owner) const {
  if (pick_.contains("vertex") == pick_.contains("face"))
    Fail("needs either a 'vertex', or a 'face' and 'barycentric'");
  SurfacePoint point;
  if (pick_.contains("vertex")) {
    point.vertices.setConstant(Index("vertex", mesh.vertex_count(), "vertices", owner));
    return point;
  }
  const int face = Index("face", mesh.face_count(), "faces", owner);
  const std::vector<double> weights = Numbers("barycentric", 3);
  point.vertices = mesh.faces.row(face).transpose();
  point.weights = {weights[0], weights[1], weights[2]};
  if (!IsInTriangle(point.weights))
    Fail(
        "has barycentric coordinates that do not lie in its triangle (three shares with the sum "
        "1); pick it again");
  return point;
}

template <class Json>
Eigen::Vector2d JsonPick<Json>::Pixel(int width, int height, const std::string& picture) const {
  const std::vector<double> pixel = Numbers("pixel", 2);
  if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] > width || pixel[1] > height)
    Fail(
        fmt::format("has pixel [{:g}, {:g}], but {} has {} x {} pixels; pick it again in its full "
                    "size",
                    pixel[0], pixel[1], picture, width, height));
  return {pixel[0], pixel[1]};
}

template class JsonPick<json>;

}  // namespace keypose
