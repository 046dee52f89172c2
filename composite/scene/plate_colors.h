// What the values of a studio's plate mean, and how they become scene light.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>

#include "composite/scene/light_file.h"
#include "composite/scene/primaries.h"
#include "core/values/image.h"

namespace keypose::composite {

/// What a person states of a plate's colours; both may be empty.
struct StatedColors {
  std::string colorspace;        ///< a space of the configuration, or one of KnownColorspaces()
  std::filesystem::path config;  ///< an OpenColorIO configuration
};

/// Names that are known without a configuration, such as "ACEScg" and "arri-logc3"; besides them
/// OpenColorIO's built-in ways to ACES2065-1 by their own names.
std::string KnownColorspaces();

/// Light is linear in these colours' primaries. What is linear in a file already stays as it is, to
/// the bit: so do pixels of a plate that nothing touches. Camera logs become ACES2065-1, those of a
/// configuration its role scene_linear; Cineon, video and sRGB keep Rec.709's primaries.
///
/// Without a statement OpenEXR is linear, of the primaries of its chromaticities, else of Rec.709;
/// DPX is as its header states its transfer characteristic, and Cineon's log where it does not.
class PlateColors {
 public:
  /// @param path  for messages
  /// @throws InputError  a configuration that is damaged or does not say how its colours relate to
  /// those of others; DPX of a transfer that is not read
  /// @throws UsageError  no such space
  PlateColors(const StatedColors& stated, const std::filesystem::path& path,
              const LightFile& header);

  /// RGB or RGBA, in place; alpha stays. Same bits for any thread count.
  void Decode(ImageF* values) const;
  /// RGB in linear light of Rec.709's primaries becomes light of these.
  void TakeFromRec709(ImageF* light) const;
  void GiveRec709(ImageF* light) const;  ///< the other way
  const Primaries& primaries() const { return primaries_; }
  const Eigen::Matrix3d& light_from_rec709() const { return light_from_rec709_; }
  /// In words: what the values were taken for.
  const std::string& meaning() const { return meaning_; }
  /// That the statement in the file is not to be trusted; else empty.
  const std::string& doubt() const { return doubt_; }

 private:
  using Curve = std::function<void(float* pixels, long count, int channels)>;

  void TakePrimaries(const Primaries& primaries);
  void TakeConfig(const StatedColors& stated, const std::filesystem::path& path);
  void TakeNamed(const std::string& name, const LightFile& header);
  void TakeExr(const LightFile& header);
  void TakeDpx(const std::filesystem::path& path, const LightFile& header);

  Primaries primaries_ = kRec709;
  Eigen::Matrix3d light_from_rec709_ = Eigen::Matrix3d::Identity();
  Curve curve_;  // none: values are light
  std::string meaning_, doubt_;
};

}  // namespace keypose::composite
