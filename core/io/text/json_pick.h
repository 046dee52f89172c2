// Reads one entry of a JSON list of picks: a place on a mesh, a pixel of a picture, plain numbers.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose {

/// Whether these barycentric coordinates lie in their triangle, as a file has them rounded: none
/// below -1e-6, their sum 1 to 1e-6.
bool IsInTriangle(const Eigen::Vector3d& barycentric);

// `Json` is nlohmann::json. Only .cpp files of core include its header.

/// The content of a JSON file. @throws InputError  no JSON, or nested too deeply; names the file
template <class Json>
Json ReadJson(const std::filesystem::path& path);

template <class Json>
class JsonPick {
 public:
  /// @param pick  must outlive this object
  /// @param file, kind, number  for messages: "clicks.json", "click", 3 (counted from 1). A pick
  /// with a name is called by it.
  /// @throws InputError  not an object
  JsonPick(const Json& pick, const std::string& file, const std::string& kind, int number);

  /// @throws InputError  always: file, pick, then `what`
  [[noreturn]] void Fail(const std::string& what) const;
  /// "click 3", or "click 'nose'".
  const std::string& title() const { return title_; }
  /// @throws InputError  the pick has no name
  std::string Name() const;
  /// @throws InputError  not a list of `count` finite numbers
  std::vector<double> Numbers(const char* name, std::size_t count) const;

  bool HasPlace() const;
  /// The place that `vertex`, or `face` and `barycentric`, name.
  /// @param owner  the mesh in messages: "template"
  /// @throws InputError  neither or both; a vertex or face that the mesh does not have; barycentric
  /// coordinates that are not IsInTriangle
  SurfacePoint Point(const Mesh& mesh, const std::string& owner) const;
  /// @param picture  in messages: "photograph a.jpg"
  /// @throws InputError  a pixel outside of 0 to width, 0 to height
  Eigen::Vector2d Pixel(int width, int height, const std::string& picture) const;

 private:
  int Index(const char* name, int count, const char* things, const std::string& owner) const;

  const Json& pick_;
  std::string file_, title_;
};

}  // namespace keypose
