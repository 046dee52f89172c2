// Bindings and places in JSON files, and the carrying over of what such a file holds to the mesh at
// hand.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/carry.h"
#include "core/io/carry_log.h"

namespace keypose {

// `Json` is nlohmann::json, whose header only the .cpp files of core include.

/// {"vertices", "faces", "sha256", "faces_sha256", "diagonal", "shape": ["x y z nx ny nz r g b",
/// ...]}
template <class Json>
Json BindingJson(const MeshBinding& binding);
/// Of older files, which only have the counts: a binding that is not known().
/// @throws InputError  malformed; names the file
template <class Json>
MeshBinding BindingFrom(const Json& json, const std::filesystem::path& file);

/// {"position", "normal", "color"}: fields of the pick's own object
template <class Json>
void AddPlace(const SurfacePlace& place, Json& pick);
template <class Json>
std::optional<SurfacePlace> PlaceFrom(const Json& pick);

/// Carries the picks of one file, on one of its meshes, and gathers what there is to say.
///
///     FollowPicks follow(binding, mesh, "landmarks/rest.json", "pose mesh");
///     for each pick: if (!follow.AsWritten()) place = follow.Carry(name, place);
///     follow.Finish(log);
class FollowPicks {
 public:
  /// @param mesh  at hand; must outlive this
  /// @param file, side  for messages: "landmarks/rest.json", "source"
  /// @throws InputError  an older file's mesh had other counts
  FollowPicks(MeshBinding binding, const Mesh& mesh, std::string file, std::string side);

  /// Whether face and vertex numbers hold: it is the mesh, or an older file that does not say
  /// which, of the same counts.
  bool AsWritten() const { return !carrier_; }
  bool known() const { return binding_.known(); }
  /// @param place  none: lost, since the file does not have it
  /// @param needed  false: it may be lost without a fault
  CarriedPlace Carry(const std::string& name, const std::optional<SurfacePlace>& place,
                     bool needed = true);
  const Carrier& carrier() const { return *carrier_; }

  /// @throws InputError  names those that could not follow, why, and the cure
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
