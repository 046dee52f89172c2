// Reads and writes bindings and places in JSON files, and transfers the picks of such a file to the
// current mesh.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/project/carry_log.h"
#include "core/surfaces/carry.h"

namespace keypose {

// `Json` is nlohmann::json. Only .cpp files of core include its header.

/// {"vertices", "faces", "sha256", "faces_sha256", "diagonal", "shape": ["x y z nx ny nz r g b",
/// ...]}
template <class Json>
Json BindingJson(const MeshBinding& binding);
/// Older files only have the counts. They give a binding that is not known().
/// @throws InputError  malformed; names the file
template <class Json>
MeshBinding BindingFrom(const Json& json, const std::filesystem::path& file);

/// Adds the fields {"position", "normal", "color"} to the pick's object.
template <class Json>
void AddPlace(const SurfacePlace& place, Json& pick);
template <class Json>
std::optional<SurfacePlace> PlaceFrom(const Json& pick);

/// Transfers the picks that one file holds for one mesh, and collects the messages about them.
///
///     FollowPicks follow(binding, mesh, "landmarks/rest.json", "pose mesh");
///     for each pick: if (!follow.AsWritten()) place = follow.Carry(name, place);
///     follow.Finish(log);
class FollowPicks {
 public:
  /// @param mesh  the current mesh; must outlive this object
  /// @param file, side  for messages: "landmarks/rest.json", "source"
  /// @throws InputError  an older file whose vertex and face counts differ from the mesh's
  FollowPicks(MeshBinding binding, const Mesh& mesh, std::string file, std::string side);

  /// Whether face and vertex numbers are valid as written: the picks were made on this mesh, or the
  /// file is an older one that gives the same counts only.
  bool AsWritten() const { return !carrier_; }
  bool known() const { return binding_.known(); }
  /// @param place  none: the pick is lost, because the file does not hold its place
  /// @param needed  false: losing it is not an error
  CarriedPlace Carry(const std::string& name, const std::optional<SurfacePlace>& place,
                     bool needed = true);
  const Carrier& carrier() const { return *carrier_; }

  /// @throws InputError  some needed picks could not be transferred; names them, the reason and the
  /// remedy
  void Finish(CarryLog* log) const;

 private:
  MeshBinding binding_;
  std::string file_, side_;
  std::unique_ptr<Carrier> carrier_;
  int carried_ = 0;
  double furthest_ = 0;
  std::vector<std::string> doubtful_, lost_;
  std::string why_all_;
};

}  // namespace keypose
